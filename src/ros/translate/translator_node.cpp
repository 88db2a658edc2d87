#include "ros/translate/translator_node.hpp"

#include <cmath>
#include <cstdlib>
#include <utility>

#include <ros/console.h>
#include <ros/init.h>
#include <ros/package.h>
#include <ros/this_node.h>

#include "ros/translate/knowledge.hpp"

namespace extperfc::ros_translate {

namespace {

using std::chrono::milliseconds;

/// How long reports and services wait for the bridge's thread: it never blocks, but may have work.
constexpr auto kAnswer = std::chrono::seconds(2);
/// Beyond the patience with the masters, for closing.
constexpr auto kClosing = std::chrono::seconds(1);
constexpr std::size_t kShownProblems = 5;

milliseconds to_ms(double seconds) {
  return milliseconds(std::llround(1e3 * seconds));
}

Result<Knowledge> load(const ros_params::TranslatorParams& params) {
  const char* search_path = std::getenv("ROS_PACKAGE_PATH");
  return load_knowledge(params, ros::package::getPath("extperfc"),
                        split_search_path(search_path == nullptr ? "" : search_path));
}

void log(const Knowledge& knowledge) {
  ROS_INFO("%s", knowledge.summary.c_str());
  const auto& problems = knowledge.problems;
  for (std::size_t i = 0; i < std::min(problems.size(), kShownProblems); ++i)
    ROS_WARN("ignoring definition: %s", problems[i].c_str());
  if (problems.size() > kShownProblems)
    ROS_WARN("ignoring %zu more definitions", problems.size() - kShownProblems);
}

/// Runs `ask` on the loop's thread and waits; nothing when it does not come to it in time.
template <typename T, typename Ask>
std::optional<T> ask_loop(translate::EventLoop& loop, Ask ask) {
  const auto answer = std::make_shared<std::promise<T>>();
  auto future = answer->get_future();
  loop.post([answer, ask] { answer->set_value(ask()); });
  if (future.wait_for(kAnswer) != std::future_status::ready) return std::nullopt;
  return future.get();
}

}  // namespace

Result<std::unique_ptr<TranslatorNode>> TranslatorNode::make(const ros::NodeHandle& handle,
                                                             const ros::NodeHandle& private_handle,
                                                             ros_params::TranslatorParams params) {
  std::unique_ptr<TranslatorNode> node(new TranslatorNode(handle, private_handle, std::move(params)));
  if (auto opened = node->open(); !opened) return tl::unexpected(opened.error());
  return node;
}

TranslatorNode::TranslatorNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                               ros_params::TranslatorParams params)
    : handle_(handle), private_handle_(private_handle), params_(std::move(params)) {
  report_params_.node = ros::this_node::getName().substr(1);
  report_params_.offset_warn_s = params_.bridge.clocks.report_above_s;
  report_params_.shift_stamps = params_.bridge.clocks.shift_stamps;
  report_params_.max_items = static_cast<std::size_t>(params_.diagnostics.max_items);
}

TranslatorNode::~TranslatorNode() {
  shut_down();
}

Result<void> TranslatorNode::open() {
  auto knowledge = load(params_);
  if (!knowledge) return tl::unexpected(knowledge.error());
  log(*knowledge);
  translate::Bridge::Handlers handlers;
  handlers.on_log = [](const std::string& line) { ROS_INFO("%s", line.c_str()); };
  handlers.on_problem = [](const std::string& line) { ROS_WARN("%s", line.c_str()); };
  handlers.on_shutdown = [] { ros::requestShutdown(); };  // the program waits for the end of ros::ok()
  auto bridge = translate::Bridge::make(loop_, params_.bridge, std::move(knowledge->definitions),
                                        std::move(knowledge->rules), std::move(handlers));
  if (!bridge) return tl::unexpected(bridge.error());
  bridge_ = std::move(*bridge);
  return {};
}

void TranslatorNode::start() {
  thread_ = std::thread([this] {
    loop_.run();
    bridge_.reset();
  });
  offer();
  timer_ = handle_.createWallTimer(ros::WallDuration(params_.diagnostics.period_s),
                                   [this](const auto&) { report(); });
}

void TranslatorNode::offer() {
  diagnostics_ = handle_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10);
  status_service_ = private_handle_.advertiseService("status", &TranslatorNode::on_status, this);
  reload_service_ = private_handle_.advertiseService("reload_rules", &TranslatorNode::on_reload_rules, this);
}

/// roscpp registers once: a master that was started again does not know us.
void TranslatorNode::offer_again() {
  diagnostics_.shutdown();
  status_service_.shutdown();
  reload_service_.shutdown();
  offer();
}

void TranslatorNode::shut_down() {
  if (!thread_.joinable()) return;
  timer_.stop();
  status_service_.shutdown();
  reload_service_.shutdown();
  const auto patience = to_ms(params_.shut_down_patience_s);
  const auto done = std::make_shared<std::promise<void>>();
  auto closed = done->get_future();
  loop_.post([this, patience, done] { bridge_->shut_down(patience, [done] { done->set_value(); }); });
  if (closed.wait_for(patience + kClosing) != std::future_status::ready)
    ROS_WARN("a master did not answer: it may list the translator's topics until it detects the shutdown");
  loop_.stop();
  thread_.join();
}

std::optional<translate::BridgeStatus> TranslatorNode::fetch_status() {
  return ask_loop<translate::BridgeStatus>(loop_, [this] { return bridge_->status(); });
}

void TranslatorNode::report() {
  const auto status = fetch_status();
  if (!status) {
    diagnostic_msgs::DiagnosticArray report;
    report.header.stamp = ros::Time::now();
    report.status.emplace_back();
    report.status.back().level = diagnostic_msgs::DiagnosticStatus::ERROR;
    report.status.back().name = report_params_.node + ": link";
    report.status.back().message = "the bridge does not answer: check the processor load";
    diagnostics_.publish(report);
    return;
  }
  const auto restarts = status->sides[static_cast<std::size_t>(translate::Side::kWorkstation)].restarts;
  if (std::exchange(restarts_, restarts) != restarts) offer_again();
  const auto now = translate::EventLoop::now();
  const bool details = !details_due_ || now >= *details_due_;
  if (details) details_due_ = now + to_ms(params_.diagnostics.topic_period_s);
  diagnostics_.publish(to_diagnostics(*status, report_params_, ros::Time::now(), details));
}

bool TranslatorNode::on_status(Trigger::Request& /*request*/, Trigger::Response& response) {
  const auto status = fetch_status();
  response.success = static_cast<std::uint8_t>(status.has_value());
  response.message = status ? to_text(*status, report_params_) : "the bridge did not answer in time";
  return true;
}

bool TranslatorNode::on_reload_rules(Trigger::Request& /*request*/, Trigger::Response& response) {
  auto knowledge = load(params_);
  if (!knowledge) {
    response.success = 0U;
    response.message = "keeping the previous rules: " + knowledge.error().message;
    ROS_WARN("%s", response.message.c_str());
    return true;
  }
  const auto rules = std::make_shared<translate::RuleSet>(std::move(knowledge->rules));
  const auto replaced = ask_loop<bool>(loop_, [this, rules] {
    bridge_->replace_rules(*rules);
    return true;
  });
  response.success = static_cast<std::uint8_t>(replaced.has_value());
  response.message = replaced ? std::to_string(rules->size()) + " rules loaded; every plan is compiled again"
                              : "the bridge did not answer in time: check ~status";
  ROS_INFO("%s", response.message.c_str());
  return true;
}

}  // namespace extperfc::ros_translate
