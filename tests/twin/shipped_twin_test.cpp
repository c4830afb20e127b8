// SPDX-License-Identifier: GPL-3.0-or-later
// The twin that ships for the quick start is what the documented command makes, and says that it is
// synthetic.
#include <gtest/gtest.h>

#include <cmath>

#include "common/capture/file/capture_file.h"
#include "tests/twin/generator.h"

namespace tenter::twin {
namespace {

TEST(ShippedTwin, IsWhatTheGeneratorMakes) {
  const Expected<capture::Capture> shipped =
      capture::read_capture(TENTER_TEST_DATA "/twin/friction_loops.h5");
  ASSERT_TRUE(shipped) << shipped.error().message;
  const Expected<Twin> twin =
      make_twin({.effects = {"internal_friction:axes"}, .size = 10.0, .seed = 3});
  ASSERT_TRUE(twin) << twin.error().message;
  const capture::Capture& made = twin->captures.front();

  EXPECT_TRUE(shipped->provenance.synthetic);
  EXPECT_NE(shipped->title.find("SYNTHETIC"), std::string::npos);
  EXPECT_EQ(shipped->protocol.name, made.protocol.name);
  EXPECT_EQ(shipped->run, made.run);
  ASSERT_EQ(shipped->channels.size(), made.channels.size());
  for (const capture::Channel& channel : made.channels) {
    const capture::Channel* stored = shipped->find(channel.name);
    ASSERT_NE(stored, nullptr) << channel.name;
    ASSERT_EQ(stored->values.size(), channel.values.size());
    // another libm may round a reading to the next step of the instrument
    for (std::size_t i = 0; i < channel.values.size(); ++i)
      ASSERT_NEAR(stored->values[i], channel.values[i], 1.01 * channel.resolution)
          << channel.name << " " << i;
  }
}

}  // namespace
}  // namespace tenter::twin
