// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/mechanics/sparse/count_allocations.h"

#include <cstddef>

namespace tenter::mechanics::test {

namespace {
thread_local long counted = 0;
}  // namespace

long allocations() {
  return counted;
}

}  // namespace tenter::mechanics::test

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

// The sanitizers bring an allocator of their own, which calls whoever asks; g++ comes without the
// header of this function (sanitizer/allocator_interface.h).
extern "C" int __sanitizer_install_malloc_and_free_hooks(  // NOLINT(bugprone-reserved-identifier)
    void (*on_allocation)(const volatile void*, std::size_t),
    void (*on_release)(const volatile void*));

namespace {
const bool is_told = [] {
  const auto on_allocation = [](const volatile void*, std::size_t) {
    ++tenter::mechanics::test::counted;
  };
  return __sanitizer_install_malloc_and_free_hooks(on_allocation, [](const volatile void*) {}) > 0;
}();
}  // namespace

#else

// glibc's allocator under its own names; operator new and BLAS come through here as well
extern "C" {
// NOLINTBEGIN(bugprone-reserved-identifier)
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
// NOLINTEND(bugprone-reserved-identifier)

void* malloc(std::size_t size) {
  ++tenter::mechanics::test::counted;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++tenter::mechanics::test::counted;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  ++tenter::mechanics::test::counted;
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++tenter::mechanics::test::counted;
  return __libc_memalign(alignment, size);
}
}

#endif
