// SPDX-License-Identifier: Apache-2.0
// What a received sample must be before anything reads it: the generated code checks neither the
// bounds of sequences nor the values of enums. "" is yes; else one sentence that names the field
// and the bound. Any octets may be in a sample; a validator never fails on them and costs no more
// than reading it once.
#pragma once

#include <string>

#include "common/wire/endpoint.h"
#include "tenter_v1.h"

namespace tenter::wire {

// clang-format off
template <> std::string check(const v1::Server& sample);
template <> std::string check(const v1::Presence& sample);
template <> std::string check(const v1::Request& sample);
template <> std::string check(const v1::Reply& sample);
template <> std::string check(const v1::JobState& sample);
template <> std::string check(const v1::JobEvent& sample);
template <> std::string check(const v1::FitProgress& sample);
template <> std::string check(const v1::Chunk& sample);     ///< includes the checksum
template <> std::string check(const v1::ChunkAck& sample);
// clang-format on

/// Well-formed UTF-8 without control characters other than tab and newline.
bool is_clean_text(const std::string& text);

/// At most `bytes` of the text, cut between characters, whatever is not clean replaced by '?': for
/// what we send.
std::string clean_text(std::string text, std::size_t bytes);

}  // namespace tenter::wire
