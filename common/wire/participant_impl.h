// SPDX-License-Identifier: Apache-2.0
// The inside of a participant, for the files of this folder that see DDS.
#pragma once

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <map>
#include <mutex>

#include "common/wire/participant.h"

namespace tenter::wire {

class Participant::Impl : public eprosima::fastdds::dds::DomainParticipantListener {
 public:
  explicit Impl(ParticipantOptions options);
  ~Impl() override;

  /// Topics are shared by the endpoints on them; null if the name is taken by another type.
  eprosima::fastdds::dds::Topic* take_topic(const std::string& name,
                                            const eprosima::fastdds::dds::TypeSupport& type);
  void release_topic(eprosima::fastdds::dds::Topic* topic);

  void on_participant_discovery(
      eprosima::fastdds::dds::DomainParticipant*,
      eprosima::fastrtps::rtps::ParticipantDiscoveryInfo&& found) override;
  void on_publisher_discovery(eprosima::fastdds::dds::DomainParticipant*,
                              eprosima::fastrtps::rtps::WriterDiscoveryInfo&& found) override;

  /// Loop thread. Sends the announcement of this participant once more.
  void announce_again();

  ParticipantOptions options_;
  std::unique_ptr<Loop> loop_;
  eprosima::fastdds::dds::DomainParticipant* participant_ = nullptr;
  eprosima::fastdds::dds::Publisher* publisher_ = nullptr;
  eprosima::fastdds::dds::Subscriber* subscriber_ = nullptr;

 private:
  std::mutex mutex_;
  std::map<eprosima::fastdds::dds::Topic*, int> topic_users_;
  std::uint32_t announcements_ = 0;
};

Peer peer_of(const eprosima::fastrtps::rtps::GuidPrefix_t& prefix);

}  // namespace tenter::wire
