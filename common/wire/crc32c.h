// SPDX-License-Identifier: Apache-2.0
// CRC-32C (Castagnoli), as in iSCSI and ext4: the checksum of a chunk. crc32c("123456789") is
// e3069283.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tenter::wire {

/// Uses the SSE4.2 instruction where the processor has it (several GB/s), else a table.
std::uint32_t crc32c(const void* data, std::size_t size);

/// The table only: the oracle of the test and the way on other processors.
std::uint32_t crc32c_table(const void* data, std::size_t size);

}  // namespace tenter::wire
