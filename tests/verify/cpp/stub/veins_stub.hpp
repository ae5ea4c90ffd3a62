// What ModelcastApp needs of OMNeT++ and Veins, in the shapes that their documentation gives, on a small
// event loop of our own: enough to compile the application and to let it drive. No line of it is theirs.

#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace omnetpp {

class SimTime {
public:
    SimTime(double t_s = 0.0) : t_s_(t_s) {}
    double dbl() const { return t_s_; }

private:
    double t_s_;
};
using simtime_t = SimTime;

class cObject {
public:
    virtual ~cObject() = default;
};

class cMessage : public cObject {
public:
    explicit cMessage(const char* name = nullptr, short kind = 0) : name_(name ? name : ""), kind_(kind) {}
    cMessage(const cMessage& other) : cObject(other), name_(other.name_), kind_(other.kind_) {}
    cMessage& operator=(const cMessage&) = delete;
    virtual cMessage* dup() const { return new cMessage(*this); }
    void setControlInfo(cObject* info) { info_.reset(info); }
    cObject* getControlInfo() const { return info_.get(); }
    void setSchedulingPriority(short priority) { priority_ = priority; }
    short getSchedulingPriority() const { return priority_; }
    bool isScheduled() const { return scheduled_; }
    bool scheduled_ = false;

private:
    std::string name_;
    short kind_, priority_ = 0;
    std::unique_ptr<cObject> info_;
};

class cPacket : public cMessage {
public:
    using cMessage::cMessage;
    void setBitLength(std::int64_t bits) { bits_ = bits; }
    std::int64_t getBitLength() const { return bits_; }

private:
    std::int64_t bits_ = 0;
};

// Events in order of time, scheduling priority and arrival.
class Simulation {
public:
    void at(double t_s, short priority, std::function<void()> what) {
        events_.emplace(Key{{t_s, priority}, number_++}, std::move(what));
    }
    void run(double until_s) {
        while (!events_.empty() && events_.begin()->first.first.first < until_s) {
            auto event = events_.extract(events_.begin());
            now_s = event.key().first.first;
            event.mapped()();
        }
    }
    double now_s = 0.0;

private:
    using Key = std::pair<std::pair<double, short>, unsigned long>;
    std::map<Key, std::function<void()>> events_;
    unsigned long number_ = 0;
};

inline Simulation& simulation() {
    static Simulation one;
    return one;
}
inline simtime_t simTime() {
    return simulation().now_s;
}

class cPar {
public:
    explicit cPar(std::string text) : text_(std::move(text)) {}
    std::string stdstringValue() const { return text_; }
    std::intmax_t intValue() const { return std::stoll(text_); }
    double doubleValue() const { return std::stod(text_); }

private:
    std::string text_;
};

class cModule : public cObject {
public:
    explicit cModule(int id = 0) : id_(id) {}
    int getId() const { return id_; }

private:
    int id_;
};

class cSimpleModule : public cModule {
public:
    cPar par(const char* name) const { return cPar(parameters.at(name)); }
    cModule* getParentModule() const { return host; }
    void scheduleAt(simtime_t t, cMessage* message) {
        message->scheduled_ = true;
        simulation().at(t.dbl(), message->getSchedulingPriority(), [this, message] {
            message->scheduled_ = false;
            handleSelf(message);
        });
    }
    void cancelAndDelete(cMessage* message) { delete message; }
    std::map<std::string, std::string> parameters;
    cModule* host = nullptr;

protected:
    virtual void handleSelf(cMessage* message) = 0;
};

}  // namespace omnetpp

#define Define_Module(name) static_assert(std::is_base_of_v<omnetpp::cModule, name>)

namespace veins {

struct Coord {
    double x = 0.0, y = 0.0, z = 0.0;
};

class BaseFrame1609_4 : public omnetpp::cPacket {
public:
    using omnetpp::cPacket::cPacket;
};

class PhyControlMessage : public omnetpp::cMessage {
public:
    void setTxPower_mW(double power) { power_ = power; }
    double getTxPower_mW() const { return power_; }

private:
    double power_ = -1.0;
};

// Of a mobility module: where a vehicle is.
struct Mobility : omnetpp::cObject {
    Coord position, speed;
};

class DemoBaseApplLayer : public omnetpp::cSimpleModule {
public:
    virtual void initialize(int) {}
    std::function<void(BaseFrame1609_4*)> to_mac;
    void from_mac(BaseFrame1609_4* frame) { onWSM(frame); }
    void moved(Mobility& mobility) { handlePositionUpdate(&mobility); }

protected:
    void handleSelf(omnetpp::cMessage* message) override { handleSelfMsg(message); }
    virtual void handlePositionUpdate(omnetpp::cObject* object) {
        const auto& mobility = dynamic_cast<Mobility&>(*object);
        curPosition = mobility.position, curSpeed = mobility.speed;
    }
    virtual void handleSelfMsg(omnetpp::cMessage*) {}
    virtual void onWSM(BaseFrame1609_4*) {}
    virtual void populateWSM(BaseFrame1609_4*) {}
    virtual void sendDelayedDown(omnetpp::cMessage* message, omnetpp::simtime_t delay) {
        auto* frame = dynamic_cast<BaseFrame1609_4*>(message);
        omnetpp::simulation().at(omnetpp::simTime().dbl() + delay.dbl(), 0, [this, frame] { to_mac(frame); });
    }
    Coord curPosition, curSpeed;
};

}  // namespace veins
