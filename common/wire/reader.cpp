// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <fastdds/dds/core/condition/StatusCondition.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>
#include <mutex>
#include <set>

#include "common/wire/endpoint.h"
#include "common/wire/loop_impl.h"
#include "common/wire/participant_impl.h"
#include "common/wire/qos.h"
#include "common/wire/types.h"

namespace tenter::wire {

namespace dds = eprosima::fastdds::dds;
using Code = eprosima::fastrtps::types::ReturnCode_t;

namespace {

constexpr int kPortion = 32;  // samples of one reader before the others have their turn

Peer peer_of_handle(const dds::InstanceHandle_t& handle) {
  eprosima::fastrtps::rtps::GUID_t guid;
  eprosima::fastrtps::rtps::iHandle2GUID(guid, handle);
  return peer_of(guid.guidPrefix);
}

}  // namespace

class ReaderCore::Impl final : public dds::DataReaderListener,
                               public Source,
                               public std::enable_shared_from_this<ReaderCore::Impl> {
 public:
  Impl(Participant& participant, Handlers handlers)
      : participant_(participant), handlers_(std::move(handlers)) {}

  // loop thread
  void open(const Topic& topic, const char* type) {
    auto& inner = participant_.impl();
    type_ = make_type(type);
    topic_ = inner.take_topic(topic.name, type_);
    if (!topic_) return;
    sample_ = type_.create_data();
    dds::StatusMask mask = dds::StatusMask::none();
    mask << dds::StatusMask::subscription_matched() << dds::StatusMask::liveliness_changed();
    reader_ = inner.subscriber_->create_datareader(topic_, reader_qos(topic), this, mask);
    if (!reader_) return;
    auto& condition = reader_->get_statuscondition();
    condition.set_enabled_statuses(dds::StatusMask::data_available());
    participant_.loop().impl().attach(condition, *this);
  }

  // loop thread
  void close() {
    auto& inner = participant_.impl();
    if (reader_) {
      reader_->set_listener(nullptr);
      participant_.loop().impl().detach(reader_->get_statuscondition());
      inner.subscriber_->delete_datareader(reader_);
      reader_ = nullptr;
    }
    if (topic_) inner.release_topic(topic_);
    topic_ = nullptr;
    if (sample_) type_.delete_data(sample_);
    sample_ = nullptr;
  }

  bool drain() override {
    dds::SampleInfo info;
    for (int i = 0; i < kPortion; ++i) {
      const Code code = reader_->take_next_sample(sample_, &info);
      if (code == Code::RETCODE_NO_DATA) return false;
      if (code != Code::RETCODE_OK) {
        ++refused_;
        return false;
      }
      hand_over(info);
    }
    return true;
  }

  void hand_over(const dds::SampleInfo& info) {
    const Peer peer = peer_of_handle(info.publication_handle);
    if (!info.valid_data) return;  // an instance has ended
    ++taken_;
    const std::string why_not = handlers_.check(sample_);
    if (why_not.empty()) {
      handlers_.sample(sample_, peer);
    } else {
      ++refused_;
      if (handlers_.refused) handlers_.refused(sample_, peer, why_not);
    }
  }

  void on_subscription_matched(dds::DataReader*,
                               const dds::SubscriptionMatchedStatus& status) override {
    const Peer peer = peer_of_handle(status.last_publication_handle);
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
    if (handlers_.match) post([peer, came](Impl& self) { self.handlers_.match(peer, came); });
  }

  void on_liveliness_changed(dds::DataReader*,
                             const dds::LivelinessChangedStatus& status) override {
    if (!handlers_.alive || status.alive_count_change == 0) return;
    const Peer peer = peer_of_handle(status.last_publication_handle);
    const bool alive = status.alive_count_change > 0;
    post([peer, alive](Impl& self) { self.handlers_.alive(peer, alive); });
  }

  template <class Function>
  void post(Function function) {
    participant_.loop().post([weak = weak_from_this(), function] {
      if (const auto self = weak.lock(); self && self->reader_) function(*self);
    });
  }

  Participant& participant_;
  const Handlers handlers_;
  dds::TypeSupport type_;
  dds::Topic* topic_ = nullptr;
  dds::DataReader* reader_ = nullptr;
  void* sample_ = nullptr;
  mutable std::mutex mutex_;
  std::multiset<Peer> peers_;
  std::atomic<std::uint64_t> taken_{0};
  std::atomic<std::uint64_t> refused_{0};
};

ReaderCore::ReaderCore(Participant& participant, const Topic& topic, const char* type,
                       Handlers handlers)
    : impl_(std::make_shared<Impl>(participant, std::move(handlers))) {
  participant.loop().run([&] { impl_->open(topic, type); });
}

ReaderCore::~ReaderCore() {
  impl_->participant_.loop().run([this] { impl_->close(); });
}

bool ReaderCore::matched(const Peer& peer) const {
  std::lock_guard lock(impl_->mutex_);
  return impl_->peers_.count(peer) > 0;
}

ReaderCounts ReaderCore::counts() const {
  return {impl_->taken_.load(), impl_->refused_.load()};
}

}  // namespace tenter::wire
