// SPDX-License-Identifier: Apache-2.0
// Every resource limit is set: the defaults refuse the eleventh instance. Data sharing and shared
// memory are off. Nothing is allocated before the first sample: the default would be a hundred
// times the largest sample.
#include "common/wire/qos.h"

namespace tenter::wire {
namespace {

namespace dds = eprosima::fastdds::dds;
using eprosima::fastrtps::Duration_t;
using std::chrono::milliseconds;

// What readers and writers have in common.
template <class Qos>
void common(Qos& qos, const Topic& topic) {
  qos.reliability().kind =
      topic.reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind =
      topic.transient_local ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = topic.keep_all ? dds::KEEP_ALL_HISTORY_QOS : dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = topic.depth;
  auto& limits = qos.resource_limits();
  limits.max_samples_per_instance = topic.depth;
  limits.max_instances = topic.max_instances;
  limits.max_samples = topic.depth * topic.max_instances;
  limits.allocated_samples = 0;
  qos.endpoint().history_memory_policy =
      topic.large ? eprosima::fastrtps::rtps::DYNAMIC_REUSABLE_MEMORY_MODE
                  : eprosima::fastrtps::rtps::DYNAMIC_RESERVE_MEMORY_MODE;
  qos.data_sharing().off();
  if (topic.liveliness.count() > 0) {
    qos.liveliness().kind = dds::AUTOMATIC_LIVELINESS_QOS;
    qos.liveliness().lease_duration = duration(topic.liveliness);
    qos.liveliness().announcement_period = duration(topic.liveliness / 5);
  }
}

}  // namespace

Duration_t duration(milliseconds value) {
  return Duration_t(static_cast<std::int32_t>(value.count() / 1000),
                    static_cast<std::uint32_t>(value.count() % 1000 * 1000000));
}

dds::DataWriterQos writer_qos(const Topic& topic) {
  dds::DataWriterQos qos;
  common(qos, topic);
  if (topic.lifespan.count() > 0) qos.lifespan().duration = duration(topic.lifespan);
  qos.reliability().max_blocking_time = duration(milliseconds(topic.keep_all ? 100 : 10));
  qos.publish_mode().kind = dds::SYNCHRONOUS_PUBLISH_MODE;
  auto& times = qos.reliable_writer_qos().times;
  times.heartbeatPeriod = duration(milliseconds(200));
  times.nackResponseDelay = duration(milliseconds(1));
  return qos;
}

dds::DataReaderQos reader_qos(const Topic& topic) {
  dds::DataReaderQos qos;
  common(qos, topic);
  if (topic.lifespan.count() > 0) qos.lifespan().duration = duration(topic.lifespan);
  auto& times = qos.reliable_reader_qos().times;
  times.heartbeatResponseDelay = duration(milliseconds(1));
  times.initialAcknackDelay = duration(milliseconds(2));
  return qos;
}

}  // namespace tenter::wire
