#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <unistd.h>

#include "extperfc/base/arguments.hpp"
#include "extperfc/base/text.hpp"
#include "extperfc/translate/event_loop.hpp"
#include "extperfc/translate/frame.hpp"
#include "extperfc/translate/peer.hpp"

#include "translate/tool/command.hpp"
#include "translate/tool/sources.hpp"

namespace extperfc::translate {
namespace {

constexpr const char* kStatusHelp =
    R"(Prints the status of a running translator: both masters, clocks, and a line for each topic and service.

  extperfc-translate status [--node NAME] [--master URI] [--timeout SEC]

Calls the node's service ~status and prints the response as text. Topics and services with a problem come first.

Options:
  --node NAME     name of the translator's ROS node, /translator by default
  --master URI    master of that node (the workstation's); ROS_MASTER_URI by default, else http://localhost:11311
  --timeout SEC   timeout for the master and the node, 5 by default, max. 60

Exit status: 0 fine, 2 no master, no translator, or no answer.
)";

constexpr const char* kTriggerMd5 = "937c9679a518e3a18d831e57125ea522";  // std_srvs/Trigger, in both eras
constexpr const char* kReload = "/reload_rules";                         // which only translators have

std::string default_master() {
  const char* environment = std::getenv("ROS_MASTER_URI");  // NOLINT(concurrency-mt-unsafe)
  return environment != nullptr && *environment != '\0' ? environment : "http://localhost:11311";
}

std::vector<std::string> translators_in(const GraphState& graph) {
  const std::string end = kReload;
  std::vector<std::string> names;
  for (const auto& [name, providers] : graph.services)
    if (name.size() > end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0)
      names.push_back(name.substr(0, name.size() - end.size()));
  return names;
}

/// The text of a serialized std_srvs/TriggerResponse: bool success, string message.
Result<std::string> text_in(const Frame& response) {
  constexpr std::size_t kText = 5;
  const auto bytes = response.payload();
  std::size_t size = 0;
  for (std::size_t i = 0; i < 4 && bytes.size >= kText; ++i)
    size |= static_cast<std::size_t>(bytes.data[1 + i]) << (8 * i);
  if (bytes.size < kText || bytes.size - kText != size)
    return fail(ErrorCode::kFailed, "the answer is not a std_srvs/TriggerResponse");
  std::string text(reinterpret_cast<const char*>(bytes.data) + kText, size);
  if (bytes.data[0] == 0) return fail(ErrorCode::kFailed, text);
  return text;
}

/// Asks one translator, on a separate event loop.
class StatusReader {
 public:
  StatusReader(std::string master_uri, std::string node, std::chrono::milliseconds patience)
      : master_uri_(std::move(master_uri)), node_(std::move(node)), patience_(patience) {}

  Result<std::string> read() {
    PeerParams params;
    params.name = "/extperfc_translate_status_" + std::to_string(getpid());
    params.master_uri = master_uri_;
    params.master_timeout = patience_;
    params.node_timeout = patience_;
    auto peer = Peer::make(loop_, frames_, params, {});
    if (!peer) return tl::unexpected(peer.error());
    peer_ = std::move(*peer);
    const auto graph = wait<GraphState>([this](auto done) { peer_->graph(std::move(done)); });
    if (!graph)
      return fail(ErrorCode::kNotFound, "no master at " + master_uri_ + ": " + graph.error().message +
                                            "; give its URI with --master");
    if (graph->services.count(node_ + "/status") == 0) return missing(*graph);
    const auto link = wait<std::shared_ptr<ServiceLink>>(
        [this](auto done) { peer_->open_service(node_ + "/status", kTriggerMd5, false, std::move(done)); });
    if (!link) return tl::unexpected(link.error());
    const auto request = std::make_shared<Frame>();
    request->seal();
    const auto response =
        wait<FramePtr>([&](auto done) { (*link)->call(request, patience_, std::move(done)); });
    if (!response) return tl::unexpected(response.error());
    return text_in(**response);
  }

 private:
  /// The answer of an asynchronous call, or an error when there is none in time.
  template <typename T, typename Ask>
  Result<T> wait(Ask ask) {
    auto answer = std::make_shared<std::optional<Result<T>>>();
    ask([answer](Result<T> result) { *answer = std::move(result); });
    const auto deadline = EventLoop::now() + patience_;
    while (!*answer && EventLoop::now() < deadline) loop_.run_once(std::chrono::milliseconds(50));
    if (!*answer) return fail(ErrorCode::kFailed, "no answer in time");
    return std::move(**answer);
  }

  Result<std::string> missing(const GraphState& graph) const {
    const auto running = translators_in(graph);
    return fail(ErrorCode::kNotFound,
                "no translator " + node_ + " at " + master_uri_ + "; " +
                    (running.empty() ? "no translator is running: roslaunch extperfc translator.launch"
                                     : "give one of these with --node: " + joined(running)));
  }

  std::string master_uri_, node_;
  std::chrono::milliseconds patience_;
  EventLoop loop_;
  FramePool frames_;
  std::unique_ptr<Peer> peer_;  ///< last: it uses what stands above
};

}  // namespace

Result<int> run_status(const Tokens& tokens) {
  const auto arguments = Arguments::read(tokens, {0, 0, {"--node", "--master", "--timeout"}, {"--help"}});
  if (!arguments) return tl::unexpected(arguments.error());
  if (arguments->has("--help")) {
    std::cout << kStatusHelp;
    return kFine;
  }
  const auto seconds = arguments->number("--timeout", 0.1, 60.0);
  if (!seconds) return tl::unexpected(seconds.error());
  auto node = arguments->last("--node").value_or("/translator");
  if (node.empty() || node.front() != '/') node = "/" + node;
  const std::chrono::milliseconds patience(static_cast<std::int64_t>(1e3 * seconds->value_or(5.0)));
  const auto text =
      StatusReader(arguments->last("--master").value_or(default_master()), node, patience).read();
  if (!text) return tl::unexpected(text.error());
  std::cout << *text;
  return kFine;
}

}  // namespace extperfc::translate
