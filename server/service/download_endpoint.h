// SPDX-License-Identifier: GPL-3.0-or-later
// Files on their way out: results, residuals, captures.
//
//   client                                                    server
//   file.open {transfer, job, file} or {transfer, capture} -> {size, sha256, chunks}
//   file.more {transfer, from, count}                      -> {sent}, and the chunks on the
//   transfer's own topic file.close {transfer}                                  -> {}
//
// The client names the transfer and asks for each portion when it has the one before, so nothing
// here waits for a client: one that stops asking is forgotten after a minute.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>

#include "common/wire/endpoint.h"
#include "server/jobs/job_service.h"
#include "server/service/context.h"
#include "server/service/operations.h"

namespace tenter::service {

class DownloadEndpoint {
 public:
  DownloadEndpoint(const Context& context, jobs::JobService& jobs);
  ~DownloadEndpoint();

  void add_operations(Operations& table);
  /// Loop thread, now and then.
  void tidy();

 private:
  struct Transfer;
  Expected<nlohmann::json> open(const Caller& caller, const nlohmann::json& body);
  Expected<nlohmann::json> more(const Caller& caller, const nlohmann::json& body);
  Expected<nlohmann::json> close(const Caller& caller, const nlohmann::json& body);
  Expected<jobs::StoredFile> file_of(const nlohmann::json& body);

  const Context context_;
  jobs::JobService& jobs_;
  std::mutex mutex_;
  std::map<wire::Uuid, std::shared_ptr<Transfer>> transfers_;
};

}  // namespace tenter::service
