// SPDX-License-Identifier: Apache-2.0
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <mutex>
#include <set>
#include <thread>

#include "common/wire/endpoint.h"
#include "common/wire/participant_impl.h"
#include "common/wire/qos.h"
#include "common/wire/types.h"

namespace tenter::wire {

namespace dds = eprosima::fastdds::dds;
using Code = eprosima::fastrtps::types::ReturnCode_t;

class WriterCore::Impl final : public dds::DataWriterListener,
                               public std::enable_shared_from_this<WriterCore::Impl> {
 public:
  Impl(Participant& participant, std::string name, MatchHandler on_match)
      : participant_(participant), name_(std::move(name)), on_match_(std::move(on_match)) {}

  void open(const Topic& topic, const char* type) {
    auto& inner = participant_.impl();
    topic_ = inner.take_topic(topic.name, make_type(type));
    if (!topic_) return;
    dds::StatusMask mask = dds::StatusMask::none();
    mask << dds::StatusMask::publication_matched();
    writer_ = inner.publisher_->create_datawriter(topic_, writer_qos(topic), this, mask);
  }

  void close() {
    auto& inner = participant_.impl();
    if (writer_) {
      writer_->set_listener(nullptr);
      inner.publisher_->delete_datawriter(writer_);
      writer_ = nullptr;
    }
    if (topic_) inner.release_topic(topic_);
    topic_ = nullptr;
  }

  void on_publication_matched(dds::DataWriter*,
                              const dds::PublicationMatchedStatus& status) override {
    eprosima::fastrtps::rtps::GUID_t guid;
    eprosima::fastrtps::rtps::iHandle2GUID(guid, status.last_subscription_handle);
    const Peer peer = peer_of(guid.guidPrefix);
    // two matches at a time are told as one of two, then one of none: the latter says nothing
    if (status.current_count_change == 0) return;
    const bool came = status.current_count_change > 0;
    {
      std::lock_guard lock(mutex_);
      if (came)
        peers_.insert(peer);
      else if (const auto one = peers_.find(peer); one != peers_.end())
        peers_.erase(one);
    }
    if (on_match_)
      participant_.loop().post([weak = weak_from_this(), peer, came] {
        if (const auto self = weak.lock()) self->on_match_(peer, came);
      });
  }

  Participant& participant_;
  const std::string name_;
  const MatchHandler on_match_;
  dds::Topic* topic_ = nullptr;
  dds::DataWriter* writer_ = nullptr;
  mutable std::mutex mutex_;
  std::multiset<Peer> peers_;
};

WriterCore::WriterCore(Participant& participant, const Topic& topic, const char* type,
                       MatchHandler on_match)
    : impl_(std::make_shared<Impl>(participant, topic.name, std::move(on_match))) {
  impl_->open(topic, type);
}

WriterCore::~WriterCore() {
  // in the loop's thread, so that no match handler runs after this
  impl_->participant_.loop().run([this] { impl_->close(); });
}

Expected<void> WriterCore::write(void* sample, std::chrono::milliseconds deadline) {
  if (!impl_->writer_)
    return fail(ErrorKind::internal, "cannot write to topic " + impl_->name_ + ": no writer");
  const auto end = std::chrono::steady_clock::now() + deadline;
  for (;;) {
    const Code code = impl_->writer_->write(sample, dds::HANDLE_NIL);
    if (code == Code::RETCODE_OK) return {};
    const bool full = code == Code::RETCODE_TIMEOUT || code == Code::RETCODE_OUT_OF_RESOURCES;
    if (!full)
      return fail(ErrorKind::internal, "writing to topic " + impl_->name_ + " failed with code " +
                                           std::to_string(code()));
    if (std::chrono::steady_clock::now() >= end)
      return fail(ErrorKind::unavailable,
                  "topic " + impl_->name_ + " is full: its reader does not keep up");
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
}

bool WriterCore::matched(const Peer& peer) const {
  std::lock_guard lock(impl_->mutex_);
  return impl_->peers_.count(peer) > 0;
}

int WriterCore::matched_count() const {
  std::lock_guard lock(impl_->mutex_);
  return static_cast<int>(impl_->peers_.size());
}

bool WriterCore::wait_acknowledged(std::chrono::milliseconds deadline) {
  if (!impl_->writer_) return false;
  return impl_->writer_->wait_for_acknowledgments(duration(deadline)) == Code::RETCODE_OK;
}

}  // namespace tenter::wire
