// SPDX-License-Identifier: GPL-3.0-or-later
// Capture files of a wanted size for tests of the way they travel; what is in them is noise.
#pragma once

#include <cstdint>
#include <filesystem>

namespace tenter::test {

/// A valid uniaxial pull with `frames` frames and `channels` extra channels of numbers that do not
/// compress. About 8 (channels + 3) bytes for each frame. The test fails if it cannot be written.
void write_noise_capture(const std::filesystem::path& path, std::size_t frames,
                         std::size_t channels, std::uint32_t seed = 1);

}  // namespace tenter::test
