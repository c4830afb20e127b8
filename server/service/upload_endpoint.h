// SPDX-License-Identifier: GPL-3.0-or-later
// Captures on their way in: chunks from a topic of the transfer's own, written by threads,
// acknowledged with credit.
//
//   client                                        server
//   capture.open {sha256, size}              ->   {transfer, chunks, missing: [[from, to], ...]} or
//   {already_stored} chunk index, data (at most the credit)   ->
//                                            <-   chunk_ack {written, credit}, after 8 chunks and
//                                            when none wait
//   capture.commit {transfer, sha256?}       ->   {capture, created}
//
// The reply to commit says that the hash is right, the content was read, the bytes are on disk and
// the capture is in the list. The sha256 of open may be a stand-in, any 64 hex digits that name the
// file, if commit brings the real one: so a client can hash while it sends, and ask capture.known
// {sha256} as soon as it knows.
//
// Opening again, also after a restart of either side, tells what is still missing. Chunks beyond
// what the queue takes are dropped: a client that keeps to its credit never sees that, another
// finds them missing.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "common/wire/endpoint.h"
#include "server/jobs/job_service.h"
#include "server/service/context.h"
#include "server/service/operations.h"
#include "server/service/work_queue.h"

namespace tenter::service {

class UploadEndpoint {
 public:
  UploadEndpoint(const Context& context, jobs::JobService& jobs);
  ~UploadEndpoint();

  void add_operations(Operations& table);
  /// Loop thread, now and then: lets go of transfers that nobody continues.
  void tidy();

 private:
  struct Transfer;
  Expected<nlohmann::json> open(const Caller& caller, const nlohmann::json& body);
  Expected<nlohmann::json> commit(const Caller& caller, const nlohmann::json& body);
  Expected<nlohmann::json> known(const nlohmann::json& body);
  Expected<nlohmann::json> abandon(const Caller& caller, const nlohmann::json& body);
  Expected<std::shared_ptr<Transfer>> find(const Caller& caller, const nlohmann::json& body);

  void take(const std::shared_ptr<Transfer>& transfer, wire::v1::Chunk& chunk);
  void write(const std::shared_ptr<Transfer>& transfer, std::uint64_t index,
             const std::vector<std::uint8_t>& data);
  void acknowledge(Transfer& transfer, std::uint32_t status, const std::string& message);
  void close(const wire::Uuid& id);

  const Context context_;
  jobs::JobService& jobs_;
  std::mutex mutex_;
  std::map<wire::Uuid, std::shared_ptr<Transfer>> transfers_;
  std::unique_ptr<WorkQueue> queue_;
};

}  // namespace tenter::service
