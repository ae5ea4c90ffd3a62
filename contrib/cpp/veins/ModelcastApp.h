// A Veins application whose messages, map and warnings are modelcast's: each vehicle of the simulation is a
// station of one session of `modelcast serve`.
//
// Put it, ModelcastApp.cc, ModelcastApp.ned and modelcast_client.hpp into a Veins project, make it the
// application of vehicles, and start `modelcast serve --socket modelcast.sock` before the simulation.
// Written for the DemoBaseApplLayer of Veins 5; docs/serve.md lists what was compared with its headers. The
// channel counts as free: a sender that heeds its load, as j2945, needs Mac1609_4's sigChannelBusy averaged
// into Step::busy_ratio.

#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "modelcast_client.hpp"
#include "veins/modules/application/ieee80211p/DemoBaseApplLayer.h"
#include "veins/modules/messages/BaseFrame1609_4_m.h"

namespace modelcast {

// What goes over Veins' air: the number that the session gave a message; its octets stay with the session.
class Frame : public veins::BaseFrame1609_4 {
public:
    explicit Frame(std::int64_t number_) : veins::BaseFrame1609_4("modelcast"), number(number_) {}
    Frame* dup() const override { return new Frame(*this); }
    const std::int64_t number;
};

// One message of a vehicle.
struct Outgoing {
    std::int64_t number;
    double send_s, power_dbm;
    std::int64_t bits;
};

// The session that all applications of a simulation share. Positions of one instant come one vehicle after
// another; when the first of them is asked to act on them, all have come, and the step is taken for all.
class Stations {
public:
    Stations(const std::string& socket, const Settings& settings);
    static std::shared_ptr<Stations> shared(const std::string& socket, const Settings& settings);

    // Where a vehicle is; a mobility module that signals twice at one instant is taken at its last word.
    void tell(std::uint32_t vehicle, double east_m, double north_m, double speed_mps, double heading_rad);
    void heard(std::uint32_t vehicle, double t_s, std::int64_t number);
    std::vector<Outgoing> act(std::uint32_t vehicle, double t_s);
    Beliefs map(std::uint32_t vehicle, double t_s) { return client_.map({vehicle}, t_s); }

private:
    void take_step(double t_s);

    Client client_;
    Step next_;
    std::set<std::uint32_t> there_;
    std::map<std::uint32_t, std::vector<Outgoing>> outgoing_;
    double last_s_ = -1.0;
};

class ModelcastApp : public veins::DemoBaseApplLayer {
public:
    ~ModelcastApp() override;
    void initialize(int stage) override;

protected:
    void handlePositionUpdate(omnetpp::cObject* object) override;
    void handleSelfMsg(omnetpp::cMessage* message) override;
    void onWSM(veins::BaseFrame1609_4* frame) override;

private:
    std::shared_ptr<Stations> stations_;
    std::uint32_t vehicle_ = 0;
    double heading_rad_ = 0.0;
    omnetpp::cMessage* act_ = nullptr;
};

}  // namespace modelcast
