#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# import_shared.sh IMPORTER DATA_DIR OUT_DIR: makes a capture of every measured file that describe/ describes.
# IMPORTER is tenter-import-csv of the build; DATA_DIR holds the data folders, which are not part of the project.
# describe/FOLDER/NAME.json is of FOLDER/NAME.csv, describe/FOLDER/sheet/NAME.json of the same as a sheet (NAME_sheet.h5),
# and describe/FOLDER/NAME/PART.json of a part of its rows (PART.h5).
set -eu
[ $# -eq 3 ] || { sed -n '3,4s/^# //p' "$0" >&2; exit 2; }
importer=$1 data=$2 out=$3
cd "$(dirname "$0")/describe"
for json in */*.json */*/*.json; do
  folder=${json%%/*} name=$(basename "$json" .json) out_name=$(basename "$json" .json)
  case $json in
    */sheet/*) out_name=${name}_sheet ;;
    */*/*) name=$(basename "$(dirname "$json")") ;;
  esac
  csv=$data/$folder/$name.csv
  [ -f "$csv" ] || { echo "$csv: not there, skipped" >&2; continue; }
  mkdir -p "$out/$folder"
  "$importer" "$csv" "$json" "$out/$folder/$out_name.h5"
  echo "$out/$folder/$out_name.h5"
done
