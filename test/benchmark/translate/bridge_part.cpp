#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>

#include <sys/epoll.h>
#include <unistd.h>

#include "extperfc/translate/bridge.hpp"

#include "test/benchmark/translate/parts.hpp"

namespace extperfc::benchmark {

namespace {

using translate::Bridge;
using translate::BridgeParams;
using translate::SideParams;

SideParams end_params(const std::string& master_uri, const std::string& set) {
  SideParams params;
  params.peer.name = "/bench_translator";
  params.peer.master_uri = master_uri;
  params.peer.advertised_host = "127.0.0.1";
  params.peer.tcpros.links = 2048;
  params.definitions = {set};
  return params;
}

Result<translate::DefinitionStore> read_definitions(const std::filesystem::path& folder) {
  translate::DefinitionStore store;
  for (const char* set : {"robot", "workstation"}) {
    const auto report = store.add_tree(folder / set, set);
    if (!report) return tl::unexpected(report.error());
    if (!report->problems.empty()) return fail(ErrorCode::kCorrupt, report->problems.front());
  }
  return store;
}

Result<void> run(const std::vector<std::string>& arguments) {
  auto store = read_definitions(arguments.at(2));
  if (!store) return tl::unexpected(store.error());
  BridgeParams params;
  params.sides = {end_params(arguments.at(0), "robot"), end_params(arguments.at(1), "workstation")};
  params.topics.allow = {"/(pass|convert|load)/.*"};
  params.rosout = false;
  translate::EventLoop loop;
  const auto log = [](const std::string& line) { std::fprintf(stderr, "translator: %s\n", line.c_str()); };
  auto bridge = Bridge::make(loop, std::move(params), std::move(*store), {}, {nullptr, log, nullptr});
  if (!bridge) return tl::unexpected(bridge.error());
  loop.watch(STDIN_FILENO, EPOLLIN, translate::Priority::kBulk, [&](std::uint32_t) {
    loop.unwatch(STDIN_FILENO);
    (*bridge)->shut_down(std::chrono::milliseconds(1'000), [&] { loop.stop(); });
  });
  loop.run();
  return {};
}

}  // namespace

int run_bridge(const std::vector<std::string>& arguments) {
  const auto done = run(arguments);
  if (!done) std::fprintf(stderr, "bench_translate: %s\n", done.error().message.c_str());
  return done ? 0 : 1;
}

}  // namespace extperfc::benchmark
