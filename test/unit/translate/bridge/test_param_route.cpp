#include <gtest/gtest.h>

#include "test/unit/translate/bridge/bridge_fixture.hpp"
#include "translate/bridge/param_route.hpp"

namespace extperfc::translate::test {
namespace {

class ParamRouteTest : public BridgeFixture {
 protected:
  ParamRoute::Written written_;
};

TEST_F(ParamRouteTest, ANamespaceIsWrittenLeafByLeaf) {
  const ParamRoute route(context_, written_, "/robot/", Side::kRobot);
  workstation_.param_values["/robot/own"] = 5;
  robot_.on_param("/robot", XmlStruct{{"a", 1}, {"deep", XmlStruct{{"b", "text"}}}});
  EXPECT_EQ(workstation_.param_values.at("/robot/a"), XmlValue(1));
  EXPECT_EQ(workstation_.param_values.at("/robot/deep/b"), XmlValue("text"));
  EXPECT_EQ(workstation_.param_values.at("/robot/own"), XmlValue(5)) << "what only the other side has, stays";
  EXPECT_EQ(route.count(), 2U);
}

TEST_F(ParamRouteTest, ADeletionIsBridged) {
  const ParamRoute route(context_, written_, "/robot", Side::kRobot);
  robot_.on_param("/robot/a", 1);
  robot_.on_param("/robot/a", XmlStruct{});
  EXPECT_EQ(workstation_.param_values.count("/robot/a"), 0U);
}

TEST_F(ParamRouteTest, ANamespaceThatIsNotThereDeletesNothing) {
  const ParamRoute route(context_, written_, "/robot", Side::kRobot);
  robot_.on_param("/robot", XmlStruct{});
  EXPECT_EQ(workstation_.writes, 0);
}

TEST_F(ParamRouteTest, BothDirectionsSettleThoughMastersEcho) {
  const ParamRoute there(context_, written_, "/x", Side::kRobot);
  const ParamRoute back(context_, written_, "/x", Side::kWorkstation);
  const auto change = [](FakePeer& peer, int value) {
    peer.param_values["/x/a"] = value;
    peer.on_param("/x/a", value);
  };
  int steps = 0;
  for (const auto& [peer, value] : {std::pair{&robot_, 1},
                                    {&workstation_, 2},
                                    {&robot_, 1},
                                    {&robot_, 3},
                                    {&workstation_, 1},
                                    {&robot_, 2}}) {
    change(*peer, value);
    ++steps;
    EXPECT_EQ(robot_.param_values.at("/x/a"), XmlValue(value)) << "step " << steps;
    EXPECT_EQ(workstation_.param_values.at("/x/a"), XmlValue(value)) << "step " << steps;
    EXPECT_EQ(robot_.writes + workstation_.writes, steps) << "one write for one change";
  }
}

TEST_F(ParamRouteTest, AMasterThatLostItsParametersGetsThemAgain) {
  ParamRoute route(context_, written_, "/x", Side::kRobot);
  robot_.param_values["/x"] = XmlStruct{{"a", 1}};
  robot_.on_param("/x/a", 1);
  workstation_.param_values.clear();
  route.write_again();
  EXPECT_EQ(workstation_.param_values.at("/x/a"), XmlValue(1));
}

}  // namespace
}  // namespace extperfc::translate::test
