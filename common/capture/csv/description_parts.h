// SPDX-License-Identifier: Apache-2.0
// Private: parts of a description that those of other kinds of capture have too. Each reads its
// keys; what is wrong is kept by the defect of the JSON object.
#pragma once

#include <string>

#include "common/capture/csv/description.h"
#include "common/capture/strict_json.h"

namespace tenter::capture {

/// separator, decimal, skip_lines, skip_rows, other_columns, where.
void read_file_options(JsonObject& table, Description& out);

/// {"is": "time"} and the like, or a channel.
ColumnDescription read_column(JsonObject& columns, const std::string& name);

/// No use twice; sigma columns are not described as something else.
void check_columns(const Description& out, JsonDefect& defect);
void check_protocol_against_columns(const Description& out, JsonDefect& defect);

void read_specimen(JsonObject object, Specimen& out);
void read_protocol(JsonObject object, Description& out);
void read_provenance(JsonObject object, Description& description);

}  // namespace tenter::capture
