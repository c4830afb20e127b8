// SPDX-License-Identifier: Apache-2.0
// Private: the names of the capture layout, shared by writer and reader. README.md explains them.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace tenter::capture::layout {

inline constexpr const char* kSchema = "tenter.capture";
inline constexpr std::int64_t kVersion = 1;
inline constexpr std::int64_t kSheetVersion = 2;  ///< version 1 and a deforming sheet

inline const std::string kEntry = "/entry";
inline const std::string kData = "/entry/data";
inline const std::string kSample = "/entry/sample";
inline const std::string kProtocol = "/entry/protocol";
inline const std::string kRuns = "/entry/runs";
inline const std::string kKinematics = "/entry/kinematics";
inline const std::string kStresses = "/entry/stresses";
inline const std::string kProvenance = "/entry/provenance";
inline const std::string kMeshes = "/entry/meshes";
inline const std::string kClips = "/entry/clips";
inline const std::string kCords = "/entry/cords";
inline const std::string kSupports = "/entry/supports";
inline const std::string kSlack = "/entry/slack";
inline const std::string kGravity = "/entry/gravity";

/// Kept free for kinds of capture that this version does not read; files may hold them.
inline constexpr std::array<const char*, 3> kForLater = {"profiles", "images", "volumes"};

}  // namespace tenter::capture::layout
