#include <utility>

#include <sys/epoll.h>

#include "translate/peer/tcpros_handshake.hpp"

namespace extperfc::translate {

struct TcprosConnector::State : std::enable_shared_from_this<State> {
  State(EventLoop& a_loop, Params a_params, Done a_done)
      : loop(a_loop),
        params(std::move(a_params)),
        done(std::move(a_done)),
        reader(params.tcpros.header_bytes) {}

  void start(Resolver& resolver);
  void connect(const Result<std::string>& address);
  void handle();
  void send_header();
  void receive_header();
  void end(Result<Outgoing> result);
  void end_with(const std::string& problem);
  void cancel();

  EventLoop& loop;
  Params params;
  Done done;
  LoopSocket socket;
  HeaderReader reader;
  BytesWriter writer;
  EventLoop::TimerId deadline{0};
  enum class Step : std::uint8_t { kConnecting, kSending, kReceiving } step{Step::kConnecting};
  bool ended{false};
};

void TcprosConnector::State::start(Resolver& resolver) {
  const std::weak_ptr<State> weak = weak_from_this();
  deadline = loop.after(params.timeout, [weak] {
    if (const auto self = weak.lock())
      self->end_with("no answer within " + std::to_string(self->params.timeout.count()) + " ms");
  });
  resolver.resolve(params.to.host, [weak](const Result<std::string>& address) {
    if (const auto self = weak.lock()) self->connect(address);
  });
}

void TcprosConnector::State::connect(const Result<std::string>& address) {
  if (ended) return;
  if (!address) return end(tl::unexpected<Error>(address.error()));
  auto begun = begin_connect(*address, params.to.port);
  if (!begun) return end(tl::unexpected<Error>(begun.error()));
  socket = std::move(*begun);
  tune(socket.get(), params.tcpros);
  const std::weak_ptr<State> weak = weak_from_this();
  socket.watch(loop, EPOLLOUT, params.priority, [weak](std::uint32_t) {
    if (const auto self = weak.lock()) self->handle();
  });
}

void TcprosConnector::State::handle() {
  if (ended) return;
  if (step == Step::kReceiving) return receive_header();
  if (step == Step::kSending) {
    const auto outcome = writer.flush(socket.get());
    if (outcome == BytesWriter::Outcome::kBroken) return end_with("it closed the connection");
    if (outcome == BytesWriter::Outcome::kEmpty) {
      step = Step::kReceiving;
      socket.want(EPOLLIN);
    }
    return;
  }
  const auto problem = connect_problem(socket.get());
  if (!problem.empty()) return end_with(problem);
  send_header();
}

void TcprosConnector::State::send_header() {
  const auto bytes = encode_header(params.header);
  const auto outcome = writer.write(socket.get(), bytes.view(), {});
  if (outcome == BytesWriter::Outcome::kBroken) return end_with("it closed the connection");
  step = outcome == BytesWriter::Outcome::kEmpty ? Step::kReceiving : Step::kSending;
  socket.want(step == Step::kReceiving ? EPOLLIN : EPOLLOUT);
}

void TcprosConnector::State::receive_header() {
  const auto outcome = reader.read(socket.get());
  if (outcome == HeaderReader::Outcome::kWaiting) return;
  if (outcome == HeaderReader::Outcome::kFailed) return end_with(reader.problem());
  socket.unwatch();
  end(Outgoing{std::move(socket), std::move(reader.header())});
}

void TcprosConnector::State::end_with(const std::string& problem) {
  end(fail(ErrorCode::kFailed, params.to.host + ":" + std::to_string(params.to.port) + ": " + problem));
}

void TcprosConnector::State::end(Result<Outgoing> result) {
  if (ended) return;
  cancel();
  const auto keep = shared_from_this();
  std::exchange(done, nullptr)(std::move(result));
}

void TcprosConnector::State::cancel() {
  ended = true;
  loop.cancel(deadline);
  deadline = 0;
  socket.close();
}

TcprosConnector::TcprosConnector(EventLoop& loop, Resolver& resolver, Params params, Done done)
    : state_(std::make_shared<State>(loop, std::move(params), std::move(done))) {
  // Later, so that `done` never runs before its owner holds this object.
  loop.post([weak = std::weak_ptr<State>(state_), &resolver] {
    const auto self = weak.lock();
    if (self && !self->ended) self->start(resolver);
  });
}

TcprosConnector::~TcprosConnector() {
  state_->cancel();
}

}  // namespace extperfc::translate
