// SPDX-License-Identifier: Apache-2.0
// Private: clips, cords and supports of a sheet from their tables.
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "common/capture/sheet_import/sheet_description.h"
#include "common/capture/sheet_import/sheet_tables.h"

namespace tenter::capture {

class SheetTracks {
 public:
  /// All must outlive this; `capture` has frames and a sheet with its vertices.
  SheetTracks(const SheetDescription& description, TableFolder& folder, const FrameIndex& frames,
              Capture& capture)
      : description_(description), folder_(folder), frames_(frames), capture_(capture) {}

  Expected<void> read(const std::unordered_map<std::string, int>& vertex_of);

 private:
  Expected<std::vector<RigidPose>> poses(const PoseSpec& spec);
  Expected<void> read_tension(const CordSpec& spec, CordTrack& cord);
  Expected<void> join_tension(const CordSpec& spec, CordTrack& cord);
  Expected<void> read_edge(const SupportSpec& spec, SupportTrack& support);
  /// bad_input where a frame has no row.
  Expected<void> all_seen(const SheetTable& table, const std::string& what,
                          const std::vector<bool>& seen) const;

  const SheetDescription& description_;
  TableFolder& folder_;
  const FrameIndex& frames_;
  Capture& capture_;
};

/// By how far the clip that travels most is from where it starts the run.
void detect_branches_of_runs(Capture& capture);

}  // namespace tenter::capture
