// Connections that end by a fault, and what the master is asked to do about them.
#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <sys/socket.h>

#include "test/unit/translate/peer/topic_helpers.hpp"

namespace extperfc::translate {
namespace {

using std::chrono::milliseconds;
using testing::frame_of;
using testing::RawSocket;

/// A subscriber as rospy makes it: it connects when the master names a publisher, and never by itself.
class RospyLike {
 public:
  RospyLike(EventLoop& loop, testing::GraphMaster& master, const std::string& name, const std::string& topic)
      : name_(name), topic_(topic), master_(master), server_(loop) {
    const auto opened =
        server_.open("127.0.0.1", 0, [this](const XmlCall& call, const std::string&) -> XmlValue {
          if (call.method == "publisherUpdate") ++updates;
          return XmlArray{1, "", 0};
        });
    if (opened) uri_ = "http://127.0.0.1:" + std::to_string(*opened) + "/";
    master_.set_subscriber(topic_, name_, uri_);
  }
  void connect(std::uint16_t port) {
    socket_ = RawSocket::connect_to(port);
    socket_.send(ConnectionHeader{{"topic", topic_}, {"md5sum", "*"}, {"type", "*"}, {"callerid", name_}});
  }
  void reset() {
    const linger at_once{1, 0};
    ::setsockopt(socket_.get(), SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
    socket_.close();
  }
  /// Unread bytes would make it a reset.
  void leave() {
    socket_.drain();
    socket_.close();
  }
  void unregister() { master_.remove_subscriber(topic_, name_, uri_); }

  int updates{0};

 private:
  std::string name_, topic_, uri_;
  testing::GraphMaster& master_;
  RpcServer server_;
  RawSocket socket_;
};

class LostLinks : public testing::Topics {
 protected:
  LostLinks() {
    auto with = params("/translator");
    with.tcpros.call_back_first = milliseconds(60);
    with.tcpros.call_back_last = milliseconds(240);
    translator_ = make(std::move(with));
  }
  void publish_to(RospyLike& listener) {
    publication_ = publish(*translator_, "/command");
    ASSERT_TRUE(until([&] { return master.publisher_count("/command") == 1; }));
    port_ = stream_port(translator_->uri(), "/command");
    connect(listener);
    for_a_while(milliseconds(50));  // our header arrives
    listener.updates = 0;
  }
  void connect(RospyLike& listener) {
    const auto before = publication_->links().size();
    listener.connect(port_);
    ASSERT_TRUE(until([&] { return publication_->links().size() == before + 1; }));
  }
  [[nodiscard]] bool until_left(std::size_t count) {
    return until([&] { return left.size() == count; });
  }

  std::unique_ptr<Peer> translator_;
  std::unique_ptr<Publication> publication_;
  std::uint16_t port_{0};
};

TEST_F(LostLinks, AResetSubscriberIsNamedThePublisherAgainUntilItComes) {
  RospyLike listener(loop, master, "/listener", "/command");
  publish_to(listener);
  listener.reset();
  ASSERT_TRUE(until_left(1));
  ASSERT_TRUE(until([&] { return listener.updates >= 4; })) << "for as long as it is missing";
  EXPECT_EQ(master.calls["unregisterPublisher"], 0) << "those who are connected keep their connections";
  connect(listener);
  for_a_while(milliseconds(100));
  const auto updates = listener.updates;
  for_a_while(milliseconds(700));
  EXPECT_EQ(listener.updates, updates) << "it is there";
}

TEST_F(LostLinks, OneThatStopsReadingIsCalledBackAsWell) {
  RospyLike listener(loop, master, "/listener", "/command");
  publish_to(listener);
  SendParams impatient;
  impatient.unacknowledged = milliseconds(200);
  publication_->configure(impatient);
  const auto id = publication_->links().at(0);
  for (int i = 0; i < 20; ++i)
    publication_->send(id, frame_of(std::string(2'000'000, 'x')), EventLoop::now());
  ASSERT_TRUE(until_left(1));
  EXPECT_TRUE(until([&] { return listener.updates >= 1; }));
}

TEST_F(LostLinks, OneThatLeavesIsLeftAlone) {
  RospyLike listener(loop, master, "/listener", "/command");
  publish_to(listener);
  listener.leave();
  ASSERT_TRUE(until_left(1));
  for_a_while(milliseconds(500));
  EXPECT_EQ(listener.updates, 0);
}

TEST_F(LostLinks, OneThatIsConnectedTwiceIsThere) {
  RospyLike first(loop, master, "/listener", "/command");
  RospyLike second(loop, master, "/listener", "/command");
  publish_to(first);
  connect(second);
  second.updates = 0;
  first.reset();
  ASSERT_TRUE(until_left(1));
  for_a_while(milliseconds(500));
  EXPECT_EQ(second.updates, 0);
}

TEST_F(LostLinks, SubscribersThatTheMasterNoLongerListsAreNotCalled) {
  RospyLike listener(loop, master, "/listener", "/command");
  RospyLike witness(loop, master, "/witness", "/command");
  publish_to(listener);
  connect(witness);
  listener.unregister();
  witness.updates = 0;
  listener.reset();
  ASSERT_TRUE(until_left(1));
  ASSERT_TRUE(until([&] { return witness.updates == 2; })) << "the second call asks who it is";
  for_a_while(milliseconds(1000));
  EXPECT_EQ(witness.updates, 2);
}

TEST_F(LostLinks, WithNoSubscriberListedTheFirstAnswerEndsIt) {
  RospyLike listener(loop, master, "/listener", "/command");
  publish_to(listener);
  listener.unregister();
  const auto registered = master.calls["registerPublisher"];
  listener.reset();
  ASSERT_TRUE(until([&] { return master.calls["registerPublisher"] == registered + 1; }));
  for_a_while(milliseconds(700));
  EXPECT_EQ(master.calls["registerPublisher"], registered + 1);
}

TEST_F(LostLinks, APublisherReplacedWithoutNotificationIsFound) {
  auto robot = make_plain("/robot");
  auto publication = publish(*robot, "/state");
  const auto subscription = subscribe(*translator_, "/state");
  ASSERT_TRUE(until([&] { return ups.size() == 1; }));
  master.notifies = false;
  const auto old_uri = robot->uri();
  publication.reset();
  robot.reset();
  robot = make_plain("/robot");
  publication = publish(*robot, "/state");
  ASSERT_NE(robot->uri(), old_uri);
  ASSERT_TRUE(until([&] { return ups.size() == 2; }));
  EXPECT_EQ(ups[1].uri, robot->uri());
  send_all(*publication, frame_of("new life"));
  EXPECT_TRUE(until([&] { return messages.size() == 1; }));
  for_a_while(milliseconds(100));
  const auto asked = master.calls["registerSubscriber"];
  for_a_while(milliseconds(700));
  EXPECT_EQ(master.calls["registerSubscriber"], asked) << "no subscriber is missing";
}

TEST_F(LostLinks, APublisherThatEndsIsNoProblem) {
  auto robot = make_plain("/robot");
  auto publication = publish(*robot, "/state");
  const auto subscription = subscribe(*translator_, "/state");
  ASSERT_TRUE(until([&] { return ups.size() == 1; }));
  master.notifies = false;  // its end is seen before the master says so
  publication.reset();
  robot.reset();
  ASSERT_TRUE(until([&] { return downs.size() == 1; }));
  for_a_while(milliseconds(400));
  EXPECT_TRUE(problems.empty()) << problems.front();
}

TEST_F(LostLinks, APublisherThatStaysAwayIsAProblem) {
  auto with = params("/watcher");
  with.tcpros.lost_grace = milliseconds(300);
  const auto watcher = make(with);
  testing::FakePublisher fake(loop);
  master.set_publishers("/state", {fake.uri});
  const auto subscription = subscribe(*watcher, "/state");
  RawSocket accepted;
  ASSERT_TRUE(until([&] { return static_cast<bool>(accepted = fake.listening.accept()); }));
  accepted.send(ConnectionHeader{{"type", "a/B"}, {"md5sum", "0"}});
  ASSERT_TRUE(until([&] { return ups.size() == 1; }));
  fake.listening.close();  // the master goes on to list it
  accepted.close();
  ASSERT_TRUE(until([&] { return downs.size() == 1; }));
  const auto lost = EventLoop::now();
  ASSERT_TRUE(until([&] { return problems.size() == 1; }));
  EXPECT_GE(EventLoop::now() - lost, milliseconds(250));
}

TEST_F(LostLinks, APublisherThatOnlyTheGraphShowsIsAskedFor) {
  const auto robot = make_plain("/robot");
  const auto subscription = subscribe(*translator_, "/state");
  ASSERT_TRUE(until([&] { return master.subscriber_count("/state") == 1; }));
  master.notifies = false;
  const auto publication = publish(*robot, "/state");
  ASSERT_TRUE(until([&] { return master.publisher_count("/state") == 1; }));
  for (int look = 0; look < 2; ++look) subscription->compare(1);
  for_a_while(milliseconds(200));
  EXPECT_TRUE(ups.empty()) << "what the master says is usually under way";
  subscription->compare(1);
  EXPECT_TRUE(until([&] { return ups.size() == 1; }));
}

TEST_F(LostLinks, ACountThatNeverFitsCostsLessAndLess) {
  const auto subscription = subscribe(*translator_, "/state");
  ASSERT_TRUE(until([&] { return master.calls["registerSubscriber"] == 1; }));
  for (int look = 0; look < 200; ++look) {
    subscription->compare(5);
    for_a_while(milliseconds(1));
  }
  for_a_while(milliseconds(100));
  EXPECT_GE(master.calls["registerSubscriber"], 4);
  EXPECT_LE(master.calls["registerSubscriber"], 1 + 3 + 6 - 2) << "3, 6, 12, 24, 48, 64, ... looks apart";
}

}  // namespace
}  // namespace extperfc::translate
