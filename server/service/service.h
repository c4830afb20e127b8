// SPDX-License-Identifier: GPL-3.0-or-later
// The daemon's face on the wire: all endpoints together, in one participant.
//
//   auto service = Service::start({.domain = 42, .name = "lab"}, *jobs);   // jobs opened, listener
//   not set jobs->start();
//   ... until a signal ...
//   jobs->stop(); service->reset(); jobs->reset();                          // in this order
//
// It translates, checks and delegates to jobs::JobService; it holds nothing that must survive.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "server/jobs/job_service.h"
#include "server/service/context.h"

namespace tenter::service {

struct ServiceOptions {
  int domain = 42;
  std::string name;                     ///< what clients may ask for; "" for the only one
  std::string software;                 ///< version shown to clients
  std::vector<std::string> interfaces;  ///< see common/wire/participant.h
  std::function<void(Level, const std::string&)> log;  ///< any thread
};

class Service {
 public:
  /// Joins the domain and answers from now on. Sets the listener of `jobs`.
  static Expected<std::unique_ptr<Service>> start(ServiceOptions options, jobs::JobService& jobs);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

 private:
  class Impl;
  Service();
  std::unique_ptr<Impl> impl_;
};

}  // namespace tenter::service
