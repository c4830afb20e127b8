// SPDX-License-Identifier: Apache-2.0
// A row of the topic table in the words of Fast DDS; for the files of this folder that see DDS.
#pragma once

#include <chrono>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include "common/wire/topics.h"

namespace tenter::wire {

eprosima::fastdds::dds::DataWriterQos writer_qos(const Topic& topic);
eprosima::fastdds::dds::DataReaderQos reader_qos(const Topic& topic);
eprosima::fastrtps::Duration_t duration(std::chrono::milliseconds value);

}  // namespace tenter::wire
