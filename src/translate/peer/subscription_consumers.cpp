#include "translate/peer/subscription_consumers.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::translate {

template <typename Report>
void Consumers::each(Report report) const {
  const auto consumers = consumers_;
  for (const auto& consumer : *consumers) {
    if (!consumer->gone) report(*consumer);
  }
}

Consumers::ConsumerPtr Consumers::add(Subscription::Handlers handlers, Priority priority) {
  auto consumer = std::make_shared<Consumer>();
  consumer->handlers = std::move(handlers);
  consumer->priority = priority;
  auto list = std::make_shared<List>(*consumers_);
  list->push_back(consumer);
  consumers_ = std::move(list);
  return consumer;
}

void Consumers::remove(const ConsumerPtr& consumer) {
  consumer->gone = true;
  auto list = std::make_shared<List>(*consumers_);
  list->erase(std::remove(list->begin(), list->end(), consumer), list->end());
  consumers_ = std::move(list);
}

Priority Consumers::priority() const {
  auto highest_priority = Priority::kBulk;
  for (const auto& consumer : *consumers_) highest_priority = std::min(highest_priority, consumer->priority);
  return highest_priority;
}

bool Consumers::want(LinkId link) const {
  return std::any_of(consumers_->begin(), consumers_->end(),
                     [link](const auto& consumer) { return consumer->links.count(link) != 0; });
}

void Consumers::up(const PublisherLink& link) const {
  each([&](Consumer& consumer) { up(consumer, link); });
}

bool Consumers::up(Consumer& consumer, const PublisherLink& link) {
  if (!consumer.links.insert(link.id).second) return false;
  if (!consumer.handlers.on_up || consumer.handlers.on_up(link)) return !consumer.gone;
  consumer.links.erase(link.id);
  return false;
}

void Consumers::message(const PublisherLink& link, const FramePtr& frame, SteadyTime received) const {
  each([&](Consumer& consumer) {
    if (consumer.links.count(link.id) != 0 && consumer.handlers.on_message)
      consumer.handlers.on_message(link, frame, received);
  });
}

void Consumers::down(const PublisherLink& link, const std::string& reason) const {
  each([&](Consumer& consumer) {
    if (consumer.links.erase(link.id) != 0 && consumer.handlers.on_down)
      consumer.handlers.on_down(link, reason);
  });
}

void Consumers::gone(const PublisherLink& link) const {
  each([&](Consumer& consumer) {
    if (consumer.handlers.on_gone) consumer.handlers.on_gone(link);
  });
}

void Consumers::problem(const std::string& uri, const std::string& reason) const {
  each([&](Consumer& consumer) {
    if (consumer.handlers.on_problem) consumer.handlers.on_problem(uri, reason);
  });
}

}  // namespace extperfc::translate
