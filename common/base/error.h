// SPDX-License-Identifier: Apache-2.0
// How a function that can fail on its input says so: Expected<T> holds a T or an Error.
//
//   Expected<Capture> capture = read_capture(path);
//   if (!capture) return tl::unexpected(capture.error());
//
// An Error is one clear sentence that names the thing (file, line, group, key) and the reason, plus
// a kind from which the command line takes its exit code. Programmer mistakes abort; they are not
// Errors.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace tenter {

/// What went wrong, seen by who has to act. The numbers are the exit codes of the command line.
enum class ErrorKind {
  internal = 1,     ///< our fault: a defect of the program
  bad_input = 2,    ///< the caller's file, option or document is wrong
  not_found = 3,    ///< no such job, capture, model, file
  refused = 4,      ///< quota, state or permission forbids it
  unavailable = 5,  ///< no server, time-out, connection lost
  no_space = 6,     ///< disk full or quota of the file system
  job_failed = 7,   ///< the job ran and ended without a result
  cancelled = 8     ///< stopped by the user
};

struct Error {
  ErrorKind kind = ErrorKind::internal;
  std::string message;
};

template <class T>
using Expected = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(ErrorKind kind, std::string message) {
  return tl::unexpected<Error>(Error{kind, std::move(message)});
}
inline tl::unexpected<Error> bad_input(std::string message) {
  return fail(ErrorKind::bad_input, std::move(message));
}

}  // namespace tenter
