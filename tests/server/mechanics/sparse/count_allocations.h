// SPDX-License-Identifier: GPL-3.0-or-later
// Counts what the thread takes from the heap, by operator new, malloc and its kin.
//
//   const long before = allocations();
//   ...
//   EXPECT_EQ(allocations(), before);
//
// Linking count_allocations.cpp puts a counter in front of the C library's allocator. Under the
// address and thread sanitizers, which bring their own, nothing is counted: counts_allocations().
#pragma once

namespace tenter::mechanics::test {

bool counts_allocations();
long allocations();  ///< of this thread since it began

}  // namespace tenter::mechanics::test
