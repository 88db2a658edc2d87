#include <baxter_core_msgs/SolvePositionIK.h>
#include <controller_manager_msgs/SwitchController.h>
#include <gazebo_msgs/GetModelState.h>
#include <std_srvs/Trigger.h>

#include "test/translator/puppet_bytes.hpp"

namespace puppet {
namespace {

template <class Service>
ros::ServiceServer serve(ros::NodeHandle& node, const std::string& name,
                         const std::shared_ptr<Bytes>& response) {
  using Request = typename Service::Request;
  using Response = typename Service::Response;
  const boost::function<bool(Request&, Response&)> answer = [name, response](Request& request,
                                                                             Response& answered) {
    report("request " + name + " " + to_hex(to_bytes(request)));
    if (!response) return false;
    answered = from_bytes<Response>(*response);
    return true;
  };
  return node.advertiseService(name, answer);
}

template <class Service>
bool call(ros::NodeHandle& node, const std::string& name, const Bytes& request_bytes, Bytes& response_bytes) {
  auto request = from_bytes<typename Service::Request>(request_bytes);
  typename Service::Response response;
  auto client = node.serviceClient<Service>(name);
  if (!client.call(request, response)) return false;
  response_bytes = to_bytes(response);
  return true;
}

template <class Service>
void add(Kinds& kinds) {
  kinds.services[ros::service_traits::DataType<Service>::value()] = {serve<Service>, call<Service>};
}

}  // namespace

void add_services(Kinds& kinds) {
  add<baxter_core_msgs::SolvePositionIK>(kinds);
  add<controller_manager_msgs::SwitchController>(kinds);
  add<gazebo_msgs::GetModelState>(kinds);
  add<std_srvs::Trigger>(kinds);
}

}  // namespace puppet
