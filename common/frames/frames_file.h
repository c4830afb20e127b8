// SPDX-License-Identifier: Apache-2.0
// Frames to HDF5, and the XDMF sidecar by which ParaView and VisIt open that file.
//
//   Expected<void> done = write_frames(frames, "out/frames.h5");
//   Expected<void> side = write_xdmf("out/frames.h5", "out/frames.xdmf");
//
// The same frames give the same bytes. The sidecar is made from the file alone, by whoever has it,
// and names it without a folder: both must lie side by side. Cost is linear in what is written;
// write_xdmf reads names and sizes only. Any thread.
#pragma once

#include <string>

#include "common/base/error.h"
#include "common/frames/frames.h"

namespace tenter::frames {

inline constexpr const char* kSchema = "tenter.frames";
inline constexpr int kVersion = 1;
inline constexpr int kMostFrames = 1'000'000;  ///< their folders have six digits

/// `frames` holds one frame at least, kMostFrames at most. A full disk is ErrorKind::no_space.
Expected<void> write_frames(const FrameSet& frames, const std::string& path);

/// The sidecar of a frames file as text; bad_input where it is none.
Expected<std::string> xdmf_of(const std::string& frames_path);
Expected<void> write_xdmf(const std::string& frames_path, const std::string& xdmf_path);

}  // namespace tenter::frames
