// SPDX-License-Identifier: Apache-2.0
// CRC-32C (Castagnoli), as in iSCSI and ext4: the checksum of a chunk on the wire and on the
// server's disk. crc32c("123456789") is e3069283.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tenter {

/// Uses the SSE4.2 instruction where the processor has it (20 GB/s and more), else a table.
/// `before` is the checksum of the bytes in front of these.
std::uint32_t crc32c(const void* data, std::size_t size, std::uint32_t before = 0);

/// The table only: the oracle of the test and the way on other processors.
std::uint32_t crc32c_table(const void* data, std::size_t size, std::uint32_t before = 0);

}  // namespace tenter
