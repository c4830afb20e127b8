// SPDX-License-Identifier: GPL-3.0-or-later
// Captures on their way in: chunks from a topic of the transfer's own, written by threads,
// acknowledged with credit.
//
//   client                                        server
//   capture.open {sha256, size}              ->   {transfer, chunks, missing: [[from, to], ...]} or
//   {already_stored} chunk index, data (at most the credit)   ->
//                                            <-   chunk_ack {written, credit}, after 8 chunks and
//                                            when none wait
//   capture.store {transfer, chunks_sha256}  ->   {stored}
//   capture.commit {transfer, sha256?}       ->   {capture, created}
//
// The reply to store says that all bytes are on disk as the client read them: chunks_sha256 is that
// of the CRC-32C of all chunks, four bytes each, least first. Nothing is read again for it. The
// reply to commit says that the content was read and is good, and that the capture is in the list
// under the hash of what is on the disk.
//
// The sha256 of open may be a stand-in, any 64 hex digits that name the file, if store is asked
// for or commit brings the real one: so a client need not hash before it sends. It may hash beside,
// and ask capture.known {sha256} as soon as it knows.
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
#include <vector>

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
  /// Written chunks lend their memory to the next: a fresh megabyte costs as much as copying one.
  class Buffers {
   public:
    std::vector<std::uint8_t> take();
    void put(std::vector<std::uint8_t> buffer);
    void clear();

   private:
    std::mutex mutex_;
    std::vector<std::vector<std::uint8_t>> kept_;
  };
  Expected<nlohmann::json> open(const Caller& caller, const nlohmann::json& body);
  Expected<nlohmann::json> store(const Caller& caller, const nlohmann::json& body);
  Expected<nlohmann::json> commit(const Caller& caller, const nlohmann::json& body);
  Expected<nlohmann::json> known(const nlohmann::json& body);
  Expected<nlohmann::json> abandon(const Caller& caller, const nlohmann::json& body);
  Expected<std::shared_ptr<Transfer>> find(const Caller& caller, const nlohmann::json& body);

  void take(const std::shared_ptr<Transfer>& transfer, wire::v1::Chunk& chunk);
  void write(const std::shared_ptr<Transfer>& transfer, std::uint64_t index, std::uint32_t crc,
             const std::vector<std::uint8_t>& data);
  void acknowledge(Transfer& transfer, std::uint32_t status, const std::string& message);
  void close(const wire::Uuid& id);
  void give_back();

  const Context context_;
  jobs::JobService& jobs_;
  std::mutex mutex_;
  std::map<wire::Uuid, std::shared_ptr<Transfer>> transfers_;
  Buffers spare_;
  std::unique_ptr<WorkQueue> queue_;
};

}  // namespace tenter::service
