// SPDX-License-Identifier: Apache-2.0
#include "common/base/crc32c.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace tenter {
namespace {

TEST(Crc32c, PublishedValues) {
  EXPECT_EQ(crc32c("123456789", 9), 0xe3069283u);
  EXPECT_EQ(crc32c("", 0), 0u);
  const std::vector<unsigned char> zeros(32, 0), ones(32, 0xff);  // RFC 3720, B.4
  EXPECT_EQ(crc32c(zeros.data(), zeros.size()), 0x8a9136aau);
  EXPECT_EQ(crc32c(ones.data(), ones.size()), 0x62a8ab43u);
}

TEST(Crc32c, InstructionAndTableAgree) {
  std::mt19937 random(7);
  std::string bytes(80000, '\0');
  for (char& c : bytes) c = static_cast<char>(random());
  for (std::size_t begin = 0; begin < 9; ++begin)
    for (std::size_t size : {0u, 1u, 7u, 8u, 9u, 63u, 64u, 4991u, 24575u, 24576u, 24577u, 79991u})
      EXPECT_EQ(crc32c(bytes.data() + begin, size), crc32c_table(bytes.data() + begin, size));
}

TEST(Crc32c, PiecesGoOnWhereTheLastOneEnded) {
  const std::string bytes(60000, 'b');
  const auto whole = crc32c(bytes.data(), bytes.size());
  for (std::size_t cut : {1u, 8u, 30000u, 59999u}) {
    const auto front = crc32c(bytes.data(), cut);
    EXPECT_NE(front, whole);
    EXPECT_EQ(crc32c(bytes.data() + cut, bytes.size() - cut, front), whole);
    EXPECT_EQ(crc32c_table(bytes.data() + cut, bytes.size() - cut, front), whole);
  }
}

TEST(Crc32c, OneFlippedBitChangesIt) {
  std::string bytes(300, 'a');
  const auto before = crc32c(bytes.data(), bytes.size());
  for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << (bit % 8)));
    EXPECT_NE(crc32c(bytes.data(), bytes.size()), before);
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << (bit % 8)));
  }
}

}  // namespace
}  // namespace tenter
