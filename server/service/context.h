// SPDX-License-Identifier: GPL-3.0-or-later
// What every endpoint of the daemon needs: the participant, who the server is, and where to
// complain.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "common/wire/participant.h"
#include "common/wire/uuid.h"

namespace tenter::service {

enum class Level { info, warning, error };

struct Context {
  wire::Participant& participant;
  wire::Uuid server_id{};
  std::uint64_t epoch = 0;
  std::function<void(Level, const std::string&)> log;
};

}  // namespace tenter::service
