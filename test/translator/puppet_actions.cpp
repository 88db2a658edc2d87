#include <actionlib/client/simple_action_client.h>
#include <actionlib/server/simple_action_server.h>
#include <control_msgs/FollowJointTrajectoryAction.h>
#include <moveit_msgs/PickupAction.h>

#include "test/translator/puppet_bytes.hpp"

namespace puppet {
namespace {

template <class Action>
class TypedServer : public ActionServer {
  using Server = actionlib::SimpleActionServer<Action>;
  using Goal = typename Action::_action_goal_type::_goal_type;
  using Result = typename Action::_action_result_type::_result_type;
  using Feedback = typename Action::_action_feedback_type::_feedback_type;

 public:
  TypedServer(ros::NodeHandle& node, const std::string& name) : server_(node, name, false) {
    server_.registerGoalCallback(
        [this, name] { report("goal " + name + " " + to_hex(to_bytes(*server_.acceptNewGoal()))); });
    server_.registerPreemptCallback([name] { report("preempt " + name); });
    server_.start();
  }
  void feedback(const Bytes& feedback) override { server_.publishFeedback(from_bytes<Feedback>(feedback)); }
  void finish(const std::string& how, const Bytes& result, const std::string& text) override {
    const auto typed = from_bytes<Result>(result);
    if (how == "succeed") server_.setSucceeded(typed, text);
    if (how == "abort") server_.setAborted(typed, text);
    if (how == "preempted") server_.setPreempted(typed, text);
  }

 private:
  Server server_;
};

template <class Action>
class TypedClient : public ActionClient {
  using Client = actionlib::SimpleActionClient<Action>;
  using Goal = typename Action::_action_goal_type::_goal_type;
  using Result = typename Action::_action_result_type::_result_type;
  using Feedback = typename Action::_action_feedback_type::_feedback_type;

 public:
  explicit TypedClient(const std::string& name) : name_(name), client_(name, true) {}
  bool wait_for_server(double seconds) override { return client_.waitForServer(ros::Duration(seconds)); }
  void send_goal(const Bytes& goal) override {
    client_.sendGoal(
        from_bytes<Goal>(goal),
        [this](const actionlib::SimpleClientGoalState& state, const boost::shared_ptr<const Result>& result) {
          const auto bytes = result ? to_bytes(*result) : Bytes();
          report("done " + name_ + " " + state.toString() + " " + to_hex(bytes) + " " + state.getText());
        },
        [this] { report("active " + name_); },
        [this](const boost::shared_ptr<const Feedback>& feedback) {
          report("feedback " + name_ + " " + to_hex(to_bytes(*feedback)));
        });
  }
  void cancel() override { client_.cancelGoal(); }

 private:
  std::string name_;
  Client client_;
};

template <class Action>
void add(Kinds& kinds, const std::string& type) {
  ActionKind kind;
  kind.serve = [](ros::NodeHandle& node, const std::string& name) {
    return std::make_unique<TypedServer<Action>>(node, name);
  };
  kind.connect = [](const std::string& name) { return std::make_unique<TypedClient<Action>>(name); };
  kinds.actions[type] = kind;
}

}  // namespace

void add_actions(Kinds& kinds) {
  add<control_msgs::FollowJointTrajectoryAction>(kinds, "control_msgs/FollowJointTrajectory");
  add<moveit_msgs::PickupAction>(kinds, "moveit_msgs/Pickup");
}

}  // namespace puppet
