// SPDX-License-Identifier: GPL-3.0-or-later
// What can be asked of the server: a table of names and functions. README.md lists their bodies.
//
// A function gets the caller and the body, delegates, and returns the reply's body. It runs in a
// thread of the work queue; slow ones have threads of their own. To add one: a function in the file
// of its topic, a line in its table.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/base/error.h"
#include "common/wire/uuid.h"

namespace tenter::service {

struct Caller {
  std::string user;  ///< from the topic's name
  wire::Uuid client{};
  wire::Uuid request{};
};

struct Operation {
  std::function<Expected<nlohmann::json>(const Caller&, const nlohmann::json&)> function;
  bool slow = false;  ///< reads or writes whole files
};

using Operations = std::map<std::string, Operation>;

}  // namespace tenter::service
