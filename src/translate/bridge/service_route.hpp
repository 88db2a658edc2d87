#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "translate/bridge/context.hpp"

namespace extperfc::translate {

/// A service of one side that is offered on the other. Each client has a separate connection to the server,
/// so that a slow call does not delay other clients.
class ServiceRoute {
 public:
  ServiceRoute(BridgeContext& context, std::string service, Side server_at);

  [[nodiscard]] ServiceStatus status() const;
  /// The server may have changed: its type is requested again.
  void forget_server();

 private:
  struct Server {
    std::string type, md5, request_type, response_type;
    ServicePtr schema;
  };
  struct Client {
    std::optional<PlanCache::ServiceConversion>
        conversion;  ///< std::nullopt: the bytes are forwarded unchanged
    std::shared_ptr<ServiceLink> link;
  };
  struct Call {
    LinkId client;
    FramePtr request;
    ServiceServer::Reply reply;
    SteadyTime since;
  };

  void on_request(std::shared_ptr<ServiceRequest> request);
  void ask_server();
  void answer(ServiceRequest& request);
  void answer_probe(ServiceRequest& request);
  void on_call(Call call);
  void forward(const std::shared_ptr<Call>& call, ServiceLink& link);
  void finish(const Call& call, const Result<FramePtr>& response);
  void refuse(const Call& call, const std::string& reason);
  [[nodiscard]] Result<std::optional<PlanCache::ServiceConversion>> conversion_for(
      const ConnectionHeader& header) const;
  [[nodiscard]] PlanOptions options() const;
  [[nodiscard]] std::function<bool()> alive() const;

  BridgeContext& context_;
  std::string service_;
  Side server_at_;
  std::optional<Server> server_;
  bool asking_{false};
  std::vector<std::shared_ptr<ServiceRequest>> waiting_;
  std::map<LinkId, Client> clients_;
  std::uint64_t calls_{0}, failed_{0};
  double latency_sum_s_{0};
  std::string problem_, plan_;
  std::shared_ptr<bool> alive_{std::make_shared<bool>(true)};  ///< answers may come after the route's end
  std::unique_ptr<ServiceServer> offered_;
};

}  // namespace extperfc::translate
