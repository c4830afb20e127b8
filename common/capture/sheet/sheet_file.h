// SPDX-License-Identifier: Apache-2.0
// Private: the part of a capture file that holds a sheet, written and read. The layout is in
// common/capture/README.md.
#pragma once

#include <string>
#include <vector>

#include "common/capture/file/layout_source.h"
#include "common/capture/sheet/sheet.h"
#include "common/h5/writer.h"

namespace tenter::capture {

/// The group of the entry that a viewer opens first: the cords' forces where there are any.
std::string default_group(const Sheet& sheet);

/// A sheet that passes validate().
void write_sheet(h5::H5Writer& file, const Sheet& sheet, std::size_t frames);

/// What fails is kept by `in`. Sizes are held against the number of frames before memory is taken;
/// whether the sheet makes sense is validate()'s question.
Sheet read_sheet(layout::Source& in, std::size_t frames, std::vector<std::string>* ignored);

}  // namespace tenter::capture
