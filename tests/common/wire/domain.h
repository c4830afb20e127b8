// SPDX-License-Identifier: Apache-2.0
// A DDS domain that no other test has at the same time, held for the object's life by a socket name
// that exists once where the domain does: in this network namespace. From 60 to 100: not the
// default of users, and with ports below those that the system gives to others.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>

namespace tenter::test {

class Domain {
 public:
  Domain() {
    for (int number = 60; number <= 100; ++number) {
      const int lock = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
      const std::string name = "tenter-test-domain-" + std::to_string(number);
      sockaddr_un address{};  // the first octet of the path stays zero: a name, not a file
      address.sun_family = AF_UNIX;
      std::memcpy(address.sun_path + 1, name.data(), name.size());
      const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
      if (::bind(lock, reinterpret_cast<const sockaddr*>(&address), length) == 0) {
        number_ = number;
        lock_ = lock;
        return;
      }
      ::close(lock);
    }
    std::abort();
  }
  ~Domain() { ::close(lock_); }
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;

  int number() const { return number_; }

 private:
  int number_ = -1;
  int lock_ = -1;
};

}  // namespace tenter::test
