#include "ModelcastApp.h"

#include <algorithm>
#include <cmath>

#include "veins/modules/messages/PhyControlMessage_m.h"

using omnetpp::cMessage;
using omnetpp::cObject;
using omnetpp::simTime;

namespace modelcast {

Define_Module(ModelcastApp);

namespace {

constexpr double kStanding_mps = 0.1;  // below, the course says nothing and the last heading holds
constexpr short kLast = 1000;          // scheduling priority: after whatever else happens at the instant
constexpr double kFarthest_s = 60.0;   // between a step and what is sent because of it
constexpr double kStrongest_dBm = 100.0;

double milliwatts(double power_dbm) {
    return std::pow(10.0, power_dbm / 10.0);
}

}  // namespace

Stations::Stations(const std::string& socket, const Settings& settings)
    : client_(Client::at_socket(socket, settings)) {}

std::shared_ptr<Stations> Stations::shared(const std::string& socket, const Settings& settings) {
    static std::weak_ptr<Stations> current;
    std::shared_ptr<Stations> found = current.lock();
    if (!found) current = found = std::make_shared<Stations>(socket, settings);
    return found;
}

void Stations::tell(std::uint32_t vehicle, double east_m, double north_m, double speed_mps,
                    double heading_rad) {
    const auto known = std::find(next_.vehicle.begin(), next_.vehicle.end(), vehicle);
    const auto row = static_cast<std::size_t>(known - next_.vehicle.begin());
    if (known == next_.vehicle.end()) next_.vehicle.push_back(vehicle);
    next_.position_m.resize(2 * next_.vehicle.size());
    next_.speed_mps.resize(next_.vehicle.size()), next_.heading_rad.resize(next_.vehicle.size());
    next_.position_m[2 * row] = east_m, next_.position_m[2 * row + 1] = north_m;
    next_.speed_mps[row] = speed_mps, next_.heading_rad[row] = heading_rad;
}

void Stations::heard(std::uint32_t vehicle, double t_s, std::int64_t number) {
    if (!there_.count(vehicle)) return;  // it has not told yet where it is
    next_.receiver.push_back(vehicle);
    next_.received_s.push_back(t_s);
    next_.message.push_back(number);
}

std::vector<Outgoing> Stations::act(std::uint32_t vehicle, double t_s) {
    if (t_s > last_s_) take_step(t_s);
    const auto found = outgoing_.extract(vehicle);
    return found.empty() ? std::vector<Outgoing>() : found.mapped();
}

void Stations::take_step(double t_s) {
    next_.t_s = last_s_ = t_s;
    const Sent sent = client_.step(next_);
    there_ = std::set<std::uint32_t>(next_.vehicle.begin(), next_.vehicle.end());
    next_ = Step();
    outgoing_.clear();
    // The client has looked at lengths and senders. Times and powers go into the simulator's own arithmetic.
    for (std::size_t row = 0; row < sent.message.size(); ++row) {
        const double send_s = sent.send_s[row], power_dbm = sent.power_dbm[row];
        if (!(std::abs(send_s - t_s) <= kFarthest_s)) throw BadAnswer("send_s", "is not near the step's time");
        if (!(std::abs(power_dbm) <= kStrongest_dBm)) throw BadAnswer("power_dbm", "is no power of a radio");
        const std::int64_t bits = 8 * std::int64_t{sent.frame_bytes[row]};
        outgoing_[sent.vehicle[row]].push_back({sent.message[row], send_s, power_dbm, bits});
    }
}

void ModelcastApp::initialize(int stage) {
    DemoBaseApplLayer::initialize(stage);
    if (stage != 0) return;
    Settings settings;
    settings.sender = par("sender").stdstringValue();
    settings.slots = par("slots").intValue();
    settings.dt_s = par("stepLength").doubleValue();
    settings.seed = par("seed").intValue();
    stations_ = Stations::shared(par("socket").stdstringValue(), settings);
    vehicle_ = static_cast<std::uint32_t>(getParentModule()->getId());
    act_ = new cMessage("act");
    act_->setSchedulingPriority(kLast);
}

ModelcastApp::~ModelcastApp() {
    cancelAndDelete(act_);
}

void ModelcastApp::handlePositionUpdate(cObject* object) {
    DemoBaseApplLayer::handlePositionUpdate(object);
    // OMNeT++ counts y southwards.
    const double east_mps = curSpeed.x, north_mps = -curSpeed.y, speed_mps = std::hypot(east_mps, north_mps);
    if (speed_mps > kStanding_mps) heading_rad_ = std::atan2(east_mps, north_mps);
    stations_->tell(vehicle_, curPosition.x, -curPosition.y, speed_mps, heading_rad_);
    if (!act_->isScheduled()) scheduleAt(simTime(), act_);
}

void ModelcastApp::handleSelfMsg(cMessage* message) {
    if (message != act_) {
        DemoBaseApplLayer::handleSelfMsg(message);
        return;
    }
    for (const Outgoing& one : stations_->act(vehicle_, simTime().dbl())) {
        auto* frame = new Frame(one.number);
        populateWSM(frame);  // channel, recipient, and the access category of dataUserPriority
        frame->setBitLength(one.bits);
        auto* power = new veins::PhyControlMessage();
        power->setTxPower_mW(milliwatts(one.power_dbm));
        frame->setControlInfo(power);
        sendDelayedDown(frame, std::max(one.send_s - simTime().dbl(), 0.0));
    }
}

void ModelcastApp::onWSM(veins::BaseFrame1609_4* frame) {
    if (const auto* ours = dynamic_cast<const Frame*>(frame))
        stations_->heard(vehicle_, simTime().dbl(), ours->number);
}

}  // namespace modelcast
