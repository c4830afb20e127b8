// SPDX-License-Identifier: Apache-2.0
#include "common/wire/validate.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "common/base/crc32c.h"

namespace tenter::wire {
namespace {

// Length in bytes of the well-formed UTF-8 character at `i`; 0 if there is none. Overlong forms,
// surrogates and what is beyond U+10FFFF are not well-formed.
std::size_t character_at(std::string_view text, std::size_t i) {
  const auto octet = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char first = octet(i);
  if (first < 0x80) return 1;
  std::size_t length = 0;
  if (first >= 0xc2 && first <= 0xdf) length = 2;
  if (first >= 0xe0 && first <= 0xef) length = 3;
  if (first >= 0xf0 && first <= 0xf4) length = 4;
  if (length == 0 || text.size() - i < length) return 0;
  for (std::size_t k = 1; k < length; ++k)
    if ((octet(i + k) & 0xc0) != 0x80) return 0;
  const unsigned char second = octet(i + 1);
  if (first == 0xe0 && second < 0xa0) return 0;
  if (first == 0xed && second > 0x9f) return 0;
  if (first == 0xf0 && second < 0x90) return 0;
  if (first == 0xf4 && second > 0x8f) return 0;
  return length;
}

bool is_control(char c) {
  const auto octet = static_cast<unsigned char>(c);
  return (octet < 0x20 && c != '\t' && c != '\n') || octet == 0x7f;
}

/// Collects the first complaint.
class Check {
 public:
  Check& at_most(const char* field, std::size_t value, std::size_t bound, const char* unit) {
    if (why_.empty() && value > bound)
      why_ = std::string(field) + " has " + std::to_string(value) + ' ' + unit + ", at most " +
             std::to_string(bound) + " are allowed";
    return *this;
  }
  Check& text(const char* field, const std::string& value, std::size_t bound) {
    at_most(field, value.size(), bound, "bytes");
    return require(field, why_.empty() ? is_clean_text(value) : true, "is not clean UTF-8 text");
  }
  Check& require(const char* field, bool condition, const char* complaint) {
    if (why_.empty() && !condition) why_ = std::string(field) + ' ' + complaint;
    return *this;
  }
  Check& id(const char* field, const Uuid& value) {
    return require(field, value != Uuid{}, "is all zero");
  }
  std::string why() const { return why_; }

 private:
  std::string why_;
};

bool is_operation(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || c == '.' || c == '_';
  });
}

}  // namespace

bool is_clean_text(const std::string& text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = character_at(text, i);
    if (length == 0 || is_control(text[i])) return false;
    i += length;
  }
  return true;
}

std::string clean_text(std::string text, std::size_t bytes) {
  std::string clean;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = character_at(text, i);
    if (clean.size() + std::max<std::size_t>(length, 1) > bytes) break;
    if (length == 0 || is_control(text[i]))
      clean += '?';
    else
      clean.append(text, i, length);
    i += std::max<std::size_t>(length, 1);
  }
  return clean;
}

template <>
std::string check(const v1::Server& s) {
  return Check()
      .id("server_id", s.server_id())
      .text("name", s.name(), v1::MAX_NAME)
      .text("software", s.software(), v1::MAX_NAME)
      .require("body_max", s.body_max() >= 1024 && s.body_max() <= v1::MAX_BODY,
               "is outside what this version of the wire allows")
      .require("chunk_bytes", s.chunk_bytes() == v1::CHUNK_BYTES,
               "is not this version's size of a chunk")
      .require("chunk_window", s.chunk_window() >= 1 && s.chunk_window() <= v1::CHUNK_WINDOW,
               "is outside what this version of the wire allows")
      .why();
}

template <>
std::string check(const v1::Presence& s) {
  return Check()
      .id("client_id", s.client_id())
      .require("user", is_user_name(s.user()), "is not a user's name")
      .text("name", s.name(), v1::MAX_NAME)
      .why();
}

template <>
std::string check(const v1::Request& s) {
  return Check()
      .id("client_id", s.client_id())
      .id("request_id", s.request_id())
      .at_most("operation", s.operation().size(), v1::MAX_NAME, "bytes")
      .require("operation", is_operation(s.operation()), "is not a name")
      .at_most("body", s.body().size(), v1::MAX_BODY, "bytes")
      .why();
}

template <>
std::string check(const v1::Reply& s) {
  return Check()
      .id("client_id", s.client_id())
      .require("status", s.status() <= 99, "is not known")
      .require("parts", s.parts() >= 1 && s.parts() <= v1::MAX_REPLY_PARTS,
               "is outside what this version of the wire allows")
      .require("part", s.part() < s.parts(), "is not below parts")
      .text("message", s.message(), v1::MAX_TEXT)
      .at_most("body", s.body().size(), v1::MAX_BODY, "bytes")
      .why();
}

template <>
std::string check(const v1::JobState& s) {
  return Check()
      .id("server_id", s.server_id())
      .require("job_id", s.job_id() > 0, "is not positive")
      .require("phase", static_cast<std::uint32_t>(s.phase()) <= v1::CANCELLED, "is not known")
      .require("user", is_user_name(s.user()), "is not a user's name")
      .text("kind", s.kind(), v1::MAX_NAME)
      .text("message", s.message(), v1::MAX_TEXT)
      .why();
}

template <>
std::string check(const v1::JobEvent& s) {
  return Check()
      .id("server_id", s.server_id())
      .require("job_id", s.job_id() > 0, "is not positive")
      .require("number", s.number() > 0, "is not positive")
      .require("phase", static_cast<std::uint32_t>(s.phase()) <= v1::CANCELLED, "is not known")
      .text("kind", s.kind(), v1::MAX_NAME)
      .text("text", s.text(), v1::MAX_TEXT)
      .why();
}

template <>
std::string check(const v1::FitProgress& s) {
  return Check()
      .id("server_id", s.server_id())
      .require("job_id", s.job_id() > 0, "is not positive")
      .text("stage", s.stage(), v1::MAX_NAME)
      .text("detail", s.detail(), v1::MAX_TEXT)
      .require("iteration", s.iteration() >= -1, "is below -1")
      .require("cost", !std::isnan(s.cost()), "is not a number")
      .require("fraction", s.fraction() <= 1.0 && s.fraction() >= -1.0, "is not within -1 to 1")
      .require("elapsed_s", std::isfinite(s.elapsed_s()) && s.elapsed_s() >= 0.0,
               "is not a duration")
      .why();
}

template <>
std::string check(const v1::Chunk& s) {
  Check checks;
  checks.id("transfer_id", s.transfer_id())
      .require("count", s.count() >= 1 && s.count() <= v1::MAX_CHUNK_COUNT,
               "is outside what this version of the wire allows")
      .require("index", s.index() < s.count(), "is not below count")
      .require("data", !s.data().empty(), "is empty")
      .at_most("data", s.data().size(), v1::CHUNK_BYTES, "bytes")
      .require("data", s.index() + 1 == s.count() || s.data().size() == v1::CHUNK_BYTES,
               "is short, and this is not the last chunk");
  if (checks.why().empty())
    checks.require("crc32c", crc32c(s.data().data(), s.data().size()) == s.crc32c(),
                   "does not fit the data");
  return checks.why();
}

template <>
std::string check(const v1::ChunkAck& s) {
  return Check()
      .id("transfer_id", s.transfer_id())
      .require("written", s.written() <= v1::MAX_CHUNK_COUNT,
               "is above the largest count of chunks")
      .require("credit", s.credit() <= v1::CHUNK_WINDOW, "is above the window")
      .require("status", s.status() <= 99, "is not known")
      .text("message", s.message(), v1::MAX_TEXT)
      .why();
}

}  // namespace tenter::wire
