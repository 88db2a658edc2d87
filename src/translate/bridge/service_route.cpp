#include "translate/bridge/service_route.hpp"

#include <utility>

namespace extperfc::translate {

ServiceRoute::ServiceRoute(BridgeContext& context, std::string service, Side server_at)
    : context_(context), service_(std::move(service)), server_at_(server_at) {
  ServiceServer::Handlers handlers;
  handlers.on_request = [this](std::shared_ptr<ServiceRequest> request) { on_request(std::move(request)); };
  handlers.on_call = [this](LinkId client, FramePtr request, ServiceServer::Reply reply) {
    on_call({client, std::move(request), std::move(reply), EventLoop::now()});
  };
  handlers.on_down = [this](LinkId client) { clients_.erase(client); };
  offered_ = context_.peer(other(server_at_)).serve(service_, std::move(handlers));
}

PlanOptions ServiceRoute::options() const {
  PlanOptions options;
  options.shift_times = context_.params.clocks.shift_stamps;
  return options;
}

std::function<bool()> ServiceRoute::alive() const {
  return [held = std::weak_ptr<bool>(alive_)] { return !held.expired(); };
}

void ServiceRoute::forget_server() {
  server_.reset();
  problem_.clear();
}

void ServiceRoute::on_request(std::shared_ptr<ServiceRequest> request) {
  if (server_) return answer(*request);
  waiting_.push_back(std::move(request));
  ask_server();
}

/// A service's type is nowhere on the wire but in its server's answer to a handshake.
void ServiceRoute::ask_server() {
  if (std::exchange(asking_, true)) return;
  context_.peer(server_at_).open_service(service_, "*", true, [this, alive = alive()](auto link) {
    if (!alive()) return;
    asking_ = false;
    auto waiting = std::exchange(waiting_, {});
    if (!link) {
      problem_ = link.error().message;
      for (const auto& request : waiting)
        request->refuse(service_ + ": the server does not answer: " + problem_);
      return;
    }
    const auto& header = (*link)->header();
    Server server{value_of(header, "type"), value_of(header, "md5sum"), value_of(header, "request_type"),
                  value_of(header, "response_type"), nullptr};
    if (server.request_type.empty()) server.request_type = server.type + "Request";
    if (server.response_type.empty()) server.response_type = server.type + "Response";
    server.schema = context_.plans.service(server.type, server.md5);
    server_ = std::move(server);
    for (const auto& request : waiting) answer(*request);
  });
}

/// Nothing when the bytes go through; else both plans; an error when there can be none.
Result<std::optional<PlanCache::ServiceConversion>> ServiceRoute::conversion_for(
    const ConnectionHeader& header) const {
  const auto md5 = value_of(header, "md5sum");
  auto type = value_of(header, "type");
  if (type.empty() || type == "*") type = server_->type;
  const bool same = md5 == "*" || md5 == server_->md5;
  if (same && (!server_->schema || !context_.params.clocks.shift_stamps)) return std::nullopt;
  const auto client = same ? server_->schema : context_.plans.service(type, md5);
  if (!client || !server_->schema) {
    const auto& missing = client ? server_->md5 : md5;
    return fail(ErrorCode::kNotFound, "there is no definition of service " + type + " with MD5 " + missing +
                                          ": add its package to the translator's definitions");
  }
  auto there = context_.plans.conversion(*client, *server_->schema, options());
  if (!there.possible()) return fail(ErrorCode::kUnsupported, there.describe());
  return there;
}

void ServiceRoute::answer(ServiceRequest& request) {
  if (request.probe()) return answer_probe(request);
  const auto conversion = conversion_for(request.header());
  if (!conversion) {
    problem_ = service_ + ": " + conversion.error().message;
    context_.problem(problem_);
    return request.refuse(problem_);
  }
  plan_ = *conversion ? (*conversion)->describe() : "pass";
  clients_[request.link()] = {*conversion, nullptr};
  const auto md5 = value_of(request.header(), "md5sum");
  request.accept(server_->type, md5 == "*" ? server_->md5 : md5, server_->request_type,
                 server_->response_type);
}

/// Tools ask for the type, then load their own class of it: this side's version, where it is known and
/// converts.
void ServiceRoute::answer_probe(ServiceRequest& request) {
  const auto native = context_.native_service(other(server_at_), server_->type);
  const bool converts =
      native && server_->schema && context_.plans.conversion(*native, *server_->schema, options()).possible();
  request.accept(server_->type, converts ? native->md5 : server_->md5, server_->request_type,
                 server_->response_type);
}

void ServiceRoute::on_call(Call call) {
  const auto found = clients_.find(call.client);
  if (found == clients_.end()) return refuse(call, "the connection has ended");
  ++calls_;
  auto& client = found->second;
  if (client.conversion && !client.conversion->request.raw()) {
    auto converted = context_.frames.take(call.request->payload().size);
    const auto result = client.conversion->request.plan->convert(call.request->payload(), converted->buffer(),
                                                                 context_.shift_ns(other(server_at_)));
    if (!result) return refuse(call, "the request cannot be converted: " + result.error().message);
    converted->seal();
    call.request = std::move(converted);
  }
  auto shared = std::make_shared<Call>(std::move(call));
  if (client.link && client.link->connected()) return forward(shared, *client.link);
  context_.peer(server_at_)
      .open_service(service_, server_ ? server_->md5 : "*", false,
                    [this, shared, alive = alive()](auto link) {
                      if (!alive()) return shared->reply(false, {});
                      const auto client_now = clients_.find(shared->client);
                      if (!link) {
                        forget_server();
                        return refuse(*shared, "the server does not answer: " + link.error().message);
                      }
                      if (client_now == clients_.end()) return refuse(*shared, "the connection has ended");
                      client_now->second.link = *link;
                      forward(shared, **link);
                    });
}  // NOLINT(clang-analyzer-cplusplus.NewDeleteLeaks): it loses sight of the shared call

void ServiceRoute::forward(const std::shared_ptr<Call>& call, ServiceLink& link) {
  const std::chrono::duration<double> timeout(context_.params.service_timeout_s);
  link.call(call->request, std::chrono::duration_cast<std::chrono::milliseconds>(timeout),
            [this, call, alive = alive()](const Result<FramePtr>& response) {
              if (alive()) finish(*call, response);
            });
}  // NOLINT(clang-analyzer-cplusplus.NewDeleteLeaks): it loses sight of the shared call

void ServiceRoute::finish(const Call& call, const Result<FramePtr>& response) {
  if (!response) return refuse(call, response.error().message);
  latency_sum_s_ += std::chrono::duration<double>(EventLoop::now() - call.since).count();
  problem_.clear();
  const auto client = clients_.find(call.client);
  if (client == clients_.end()) return;
  const auto& conversion = client->second.conversion;
  if (!conversion || conversion->response.raw()) return call.reply(true, (*response)->payload());
  ByteBuffer converted((*response)->payload().size);
  const auto result =
      conversion->response.plan->convert((*response)->payload(), converted, context_.shift_ns(server_at_));
  if (!result) return refuse(call, "the response cannot be converted: " + result.error().message);
  call.reply(true, converted.view());
}

void ServiceRoute::refuse(const Call& call, const std::string& reason) {
  ++failed_;
  problem_ = service_ + ": " + reason;
  call.reply(false, {reinterpret_cast<const std::uint8_t*>(reason.data()), reason.size()});
}

ServiceStatus ServiceRoute::status() const {
  ServiceStatus status;
  status.service = service_;
  status.from = server_at_;
  if (server_) {
    status.type = server_->type;
    status.md5 = server_->md5;
  }
  status.plan = plan_;
  status.problem = problem_;
  status.calls = calls_;
  status.failed = failed_;
  if (calls_ > failed_) status.latency_mean_s = latency_sum_s_ / static_cast<double>(calls_ - failed_);
  return status;
}

}  // namespace extperfc::translate
