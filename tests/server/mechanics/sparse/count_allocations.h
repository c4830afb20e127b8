// SPDX-License-Identifier: GPL-3.0-or-later
// Counts what the thread takes from the heap, by operator new, malloc and its kin.
//
//   const long before = allocations();
//   ...
//   EXPECT_EQ(allocations(), before);
//
// Linking count_allocations.cpp puts a counter in front of the C library's allocator, or has that
// of the address or thread sanitizer tell.
#pragma once

namespace tenter::mechanics::test {

long allocations();  ///< of this thread since it began

}  // namespace tenter::mechanics::test
