// SPDX-License-Identifier: GPL-3.0-or-later
// The answer to a request before it is cut into samples.
#pragma once

#include <string>

#include "common/base/error.h"

namespace tenter::service {

struct ReplyText {
  bool ok = true;
  ErrorKind kind = ErrorKind::internal;  ///< when not ok
  std::string message;                   ///< when not ok
  std::string body;                      ///< one JSON object, when ok
};

}  // namespace tenter::service
