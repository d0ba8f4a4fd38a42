// ROS 1 with std_msgs/UInt8MultiArray: between processes over TCPROS (tcpros); in one process with a message passed by
// reference, which roscpp serializes and parses (roscpp), and by shared pointer, as nodelets do (nodelet). Its queue
// drops the oldest message when it is full.
#include <ros/ros.h>
#include <std_msgs/UInt8MultiArray.h>

#include <boost/make_shared.hpp>

#include "buffers.hpp"
#include "peer.hpp"

namespace hgros::bench {
namespace {

using Message = std_msgs::UInt8MultiArray;

Message::Ptr FilledMessage(std::size_t size_bytes) {
  auto message = boost::make_shared<Message>();
  message->data.resize(size_bytes);
  Fill(reinterpret_cast<std::byte*>(message->data.data()), size_bytes);
  return message;
}

class RosInlet final : public Inlet {
 public:
  RosInlet(ros::NodeHandle& node, const Lane& lane, Sink& sink)
      : subscriber_(node.subscribe<Message>(
            lane.name, static_cast<std::uint32_t>(lane.depth()),
            [&sink](const Message::ConstPtr& message) { sink.Note(message->data.data(), message->data.size()); },
            ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay())) {}

 private:
  ros::Subscriber subscriber_;
};

class RosOutlet final : public Outlet {
 public:
  RosOutlet(ros::NodeHandle& node, const Lane& lane, bool by_pointer)
      : publisher_(node.advertise<Message>(lane.name, static_cast<std::uint32_t>(lane.depth()))),
        ring_(by_pointer ? lane.depth() + 2 : 1, [&] { return FilledMessage(lane.size_bytes); }),
        by_pointer_(by_pointer) {}
  std::byte* Take() override {
    connected_ = connected_ || publisher_.getNumSubscribers() > 0;
    if (!connected_) return nullptr;
    taken_ = ring_.Take();
    return reinterpret_cast<std::byte*>(taken_->data.data());
  }
  bool Publish() override {
    if (by_pointer_) {
      publisher_.publish(taken_);
    } else {
      publisher_.publish(*taken_);
    }
    taken_.reset();
    return true;
  }

 private:
  ros::Publisher publisher_;
  PointerRing<Message::Ptr> ring_;
  bool by_pointer_;
  bool connected_ = false;
  Message::Ptr taken_;
};

class Ros1 final : public Peer {
 public:
  explicit Ros1(const Task& task) : by_pointer_(task.mode == "nodelet") {
    ros::M_string no_remappings;
    const std::string side = task.role == Task::Role::kPublish ? "_pub" : "_sub" + std::to_string(task.receiver);
    ros::init(no_remappings, task.name + side, ros::init_options::NoSigintHandler);
    node_ = std::make_unique<ros::NodeHandle>();
    spinner_ = std::make_unique<ros::AsyncSpinner>(1);
    spinner_->start();
  }
  std::unique_ptr<Inlet> Subscribe(const Lane& lane, Sink& sink) override {
    return std::make_unique<RosInlet>(*node_, lane, sink);
  }
  std::unique_ptr<Outlet> Publish(const Lane& lane) override {
    return std::make_unique<RosOutlet>(*node_, lane, by_pointer_);
  }

 private:
  bool by_pointer_;
  std::unique_ptr<ros::NodeHandle> node_;
  std::unique_ptr<ros::AsyncSpinner> spinner_;
};

}  // namespace

std::unique_ptr<Peer> MakePeer(const Task& task) {
  if (task.mode != "tcpros" && task.mode != "roscpp" && task.mode != "nodelet") {
    Fail("ROS 1 has no mode \"" + task.mode + "\"");
  }
  return std::make_unique<Ros1>(task);
}

}  // namespace hgros::bench
