#include "extperfc/translate/peer.hpp"

#include <utility>

#include "translate/peer/peer_core.hpp"
#include "translate/peer/publication.hpp"
#include "translate/peer/service_link.hpp"
#include "translate/peer/service_server.hpp"
#include "translate/peer/subscription.hpp"

namespace extperfc::translate {
namespace {

std::function<void(Result<XmlValue>)> without_value(std::function<void(Result<void>)> done) {
  return [done = std::move(done)](const Result<XmlValue>& value) {
    if (!done) return;
    if (value) {
      done({});
    } else {
      done(tl::unexpected<Error>(value.error()));
    }
  };
}

class PeerNode : public Peer {
 public:
  explicit PeerNode(std::shared_ptr<PeerCore> core) : core_(std::move(core)) {}
  ~PeerNode() override { core_->close(); }
  PeerNode(const PeerNode&) = delete;
  PeerNode& operator=(const PeerNode&) = delete;

  const PeerParams& params() const override { return core_->params; }
  const std::string& uri() const override { return core_->uri; }
  const MasterStatus& master() const override { return core_->master->status(); }
  void graph(std::function<void(Result<GraphState>)> done) override { core_->master->graph(std::move(done)); }

  std::unique_ptr<Publication> advertise(const std::string& topic, const std::string& type,
                                         Publication::Handlers handlers, const SendParams& params) override {
    return make_publication(core_, topic, type, std::move(handlers), params);
  }
  std::unique_ptr<Subscription> subscribe(const std::string& topic, Subscription::Handlers handlers,
                                          const Subscription::Params& params) override {
    return make_subscription(core_, topic, std::move(handlers), params);
  }
  std::unique_ptr<ServiceServer> serve(const std::string& service,
                                       ServiceServer::Handlers handlers) override {
    return make_service_server(core_, service, std::move(handlers));
  }
  void open_service(const std::string& service, const std::string& md5, bool probe,
                    std::function<void(Result<std::shared_ptr<ServiceLink>>)> done) override {
    open_service_link(core_, service, md5, probe, std::move(done));
  }

  void get_param(const std::string& name, std::function<void(Result<XmlValue>)> done) override;
  void set_param(const std::string& name, const XmlValue& value,
                 std::function<void(Result<void>)> done) override {
    core_->master->call("setParam", {name, value}, without_value(std::move(done)));
  }
  void delete_param(const std::string& name, std::function<void(Result<void>)> done) override;
  void watch_param(const std::string& prefix,
                   std::function<void(const std::string&, const XmlValue&)> on_change) override;

  void shut_down(std::chrono::milliseconds patience, std::function<void()> done) override {
    core_->master->shut_down(patience, std::move(done));
  }

 private:
  /// The master's refusal does not say why: asks whether the parameter exists.
  void explain_missing(const std::string& name, const Error& error, std::function<void(Error)> done);

  std::shared_ptr<PeerCore> core_;
};

void PeerNode::explain_missing(const std::string& name, const Error& error, std::function<void(Error)> done) {
  core_->master->call("hasParam", {name},
                      [name, error, done = std::move(done)](const Result<XmlValue>& answer) {
                        const auto* exists = answer ? answer->as<bool>() : nullptr;
                        if (exists != nullptr && !*exists)
                          return done(Error{ErrorCode::kNotFound, "there is no parameter " + name});
                        done(error);
                      });
}

void PeerNode::get_param(const std::string& name, std::function<void(Result<XmlValue>)> done) {
  const std::weak_ptr<PeerCore> weak = core_;
  core_->master->call("getParam", {name}, [this, weak, name, done = std::move(done)](Result<XmlValue> value) {
    if (value) return done(std::move(value));
    const auto core = weak.lock();
    if (!core || core->closed) return;
    explain_missing(name, value.error(),
                    [done](Error error) { done(tl::unexpected<Error>(std::move(error))); });
  });
}

void PeerNode::delete_param(const std::string& name, std::function<void(Result<void>)> done) {
  const std::weak_ptr<PeerCore> weak = core_;
  core_->master->call(
      "deleteParam", {name}, [this, weak, name, done = std::move(done)](const Result<XmlValue>& value) {
        if (value) return done({});
        const auto core = weak.lock();
        if (!core || core->closed) return;
        explain_missing(name, value.error(),
                        [done](Error error) { done(tl::unexpected<Error>(std::move(error))); });
      });
}

void PeerNode::watch_param(const std::string& prefix,
                           std::function<void(const std::string&, const XmlValue&)> on_change) {
  const auto watch =
      std::make_shared<PeerCore::ParamWatch>(PeerCore::ParamWatch{prefix, std::move(on_change)});
  core_->param_watches.push_back(watch);
  core_->master->keep_param_watch(prefix,
                                  [weak = core_->weak_from_this(), watch](const Result<XmlValue>& value) {
                                    const auto core = weak.lock();
                                    if (core && !core->closed && value)
                                      watch->on_change(watch->prefix, *value);
                                  });
}

}  // namespace

Result<std::unique_ptr<Peer>> Peer::make(EventLoop& loop, FramePool& frames, PeerParams params,
                                         Handlers handlers) {
  auto core = std::make_shared<PeerCore>(loop, frames, std::move(params), std::move(handlers));
  if (auto opened = core->open(); !opened) return tl::unexpected<Error>(opened.error());
  return std::make_unique<PeerNode>(std::move(core));
}

}  // namespace extperfc::translate
