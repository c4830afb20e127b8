#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# generate.sh FASTDDSGEN FILE.idl FOLDER: runs the generator; fails, showing its output and leaving no half-made
# source, when it printed an error, whatever its exit code.
generator=$1 file=$2 folder=$3
log=$folder/$(basename "$file" .idl).log
if "$generator" -cs -replace -d "$folder" "$file" >"$log" 2>&1 &&
   ! grep -q -i -e exception -e 'error' "$log"; then
  exit 0
fi
cat "$log" >&2
rm -f "$folder"/*.cxx
exit 1
