#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# import_shared.sh IMPORTER DATA_DIR OUT_DIR: makes a capture of every measured file that describe/ describes.
# IMPORTER is tenter-import-csv of the build; DATA_DIR holds the data folders, which are not part of the project.
set -eu
[ $# -eq 3 ] || { sed -n '3,4s/^# //p' "$0" >&2; exit 2; }
importer=$1 data=$2 out=$3
describe=$(dirname "$0")/describe
for json in "$describe"/*/*.json "$describe"/*/sheet/*.json; do
  name=$(basename "$json" .json)
  case $json in
    */sheet/*) folder=$(basename "$(dirname "$(dirname "$json")")") out_name=${name}_sheet ;;
    *) folder=$(basename "$(dirname "$json")") out_name=$name ;;
  esac
  csv=$data/$folder/$name.csv
  [ -f "$csv" ] || { echo "$csv: not there, skipped" >&2; continue; }
  mkdir -p "$out/$folder"
  "$importer" "$csv" "$json" "$out/$folder/$out_name.h5"
  echo "$out/$folder/$out_name.h5"
done
