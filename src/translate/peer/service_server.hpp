#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "translate/peer/peer_core.hpp"
#include "translate/peer/tcpros_frame_reader.hpp"
#include "translate/peer/tcpros_stall.hpp"

namespace extperfc::translate {

/// A service's clients: each is read one request at a time, and the next one when its answer has left.
class ServiceServerState : public std::enable_shared_from_this<ServiceServerState> {
 public:
  ServiceServerState(std::shared_ptr<PeerCore> core, std::string name, ServiceServer::Handlers handlers);

  void open();
  void close();
  void incoming(Incoming incoming);

  void accept(LinkId id, const std::string& type, const std::string& md5, const std::string& request_type,
              const std::string& response_type);
  void refuse(LinkId id, const std::string& reason);
  void reply(LinkId id, std::uint64_t call, bool ok, ByteView response);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] MasterLink::RegistrationId registration() const { return registration_; }

 private:
  enum class Step : std::uint8_t { kPending, kIdle, kCalling, kWriting };
  struct Client {
    Client(EventLoop& loop, std::function<void()> on_stall)
        : stall(
              loop, [this] { return writer.bytes_written(); }, std::move(on_stall)) {}
    LoopSocket socket;
    Step step{Step::kPending};
    bool accepted{false};
    bool probe{false}, persistent{false};
    EventLoop::TimerId deadline{0};
    std::uint64_t call{0};
    std::unique_ptr<FrameReader> reader;
    BytesWriter writer;
    StallWatch stall;
  };
  using ClientPtr = std::shared_ptr<Client>;

  void watch(LinkId id, Client& client);
  void handle(LinkId id, std::uint32_t events);
  void read(LinkId id, const ClientPtr& client);
  void start_call(LinkId id, Client& client, std::shared_ptr<Frame> request);
  void write(LinkId id, Client& client, ByteView head, ByteView body);
  void written(LinkId id, Client& client, BytesWriter::Outcome outcome);
  void end(LinkId id);

  std::shared_ptr<PeerCore> core_;
  std::string name_;
  ServiceServer::Handlers handlers_;
  MasterLink::RegistrationId registration_{0};
  std::map<LinkId, ClientPtr> clients_;
  bool closed_{false};
};

[[nodiscard]] std::unique_ptr<ServiceServer> make_service_server(const std::shared_ptr<PeerCore>& core,
                                                                 const std::string& name,
                                                                 ServiceServer::Handlers handlers);

}  // namespace extperfc::translate
