// IEEE 802.11p of ns-3 in lock-step: reads a step on standard input, runs to its end, writes what became of it.
//
// Numbers are little-endian, as x86 and ARM have them; V is the number of stations.
//   in   double until_s, int64 M; V x (double east_m, north_m; NaN: absent);
//        M x (double ready_s, power_dbm; int64 id; int32 sender, bytes)
//   out  int64 P, E, X; P x (int64 id; double end_s, rssi_dbm; int32 receiver, outcome);
//        E x int64 id, frames that ended; X x int64 id, messages never sent; V x double busy ratio
// The end of the input is the end of the program.
#include <cmath>
#include <cstdio>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "ns3/core-module.h"
#include "ns3/mobility-module.h"
#include "ns3/network-module.h"
#include "ns3/propagation-module.h"
#include "ns3/wifi-module.h"

using namespace ns3;

namespace {

constexpr uint32_t OVERHEAD = 36;  // MAC header 24, FCS 4, LLC and SNAP 8
constexpr double ABSENT_M = 1e9, LIGHT_MPS = 299792458.0;
enum Outcome : int32_t { RECEIVED, HALF_DUPLEX, BELOW_SENSITIVITY, HIDDEN, CONCURRENT };

struct Place { double x, y; };
struct Message { double readyS, powerDbm; int64_t id; int32_t sender, bytes; };
struct Pair { int64_t id; double endS, rssiDbm; int32_t receiver, outcome; };

struct Frame {
    int64_t id;
    uint64_t packet;  // ns-3's number of it
    uint32_t sender;
    double startS, endS;
    double farthestM;
    std::vector<double> mw;        // power at every station
    std::vector<double> receivedS;  // NaN where it was not received
};

struct Station {
    Ptr<NetDevice> device;
    Ptr<WifiPhy> phy;
    Ptr<Txop> access;
    Ptr<MobilityModel> mobility;
    bool present = false;
    std::shared_ptr<Message> waiting, later;  // handed to the MAC; to be handed over when the own frame ends
    uint64_t packet = 0;                      // ns-3's number of the one that waits
    std::shared_ptr<Frame> sending;
    double airMw = 0.0, busyS = 0.0, sinceS = 0.0, ratio = 0.0;
};

double loadMw, noiseMw, sensitivityMw, reachM, slotS, windowS;
std::vector<Station> stations;
std::map<uint64_t, int64_t> idOfPacket;
std::map<int64_t, std::shared_ptr<Frame>> frames;  // on the air, or not yet judged
std::deque<std::shared_ptr<Frame>> judged;         // may still overlap one that is not
std::shared_ptr<Frame> beginning;
uint32_t onAir = 0;
std::vector<Pair> pairs;
std::vector<int64_t> ended, expired;

double NowS() { return Simulator::Now().GetSeconds(); }
double Milliwatts(double dbm) { return std::pow(10.0, dbm / 10.0); }

/// The last of the chain of losses: it changes nothing and notes the power that arrives.
class PowerTap : public PropagationLossModel {
  public:
    static TypeId GetTypeId() {
        static TypeId tid = TypeId("modelcast::PowerTap").SetParent<PropagationLossModel>();
        return tid;
    }

  private:
    double DoCalcRxPower(double dbm, Ptr<MobilityModel> from, Ptr<MobilityModel> to) const override {
        uint32_t receiver = to->GetObject<Node>()->GetId();
        if (beginning && stations[receiver].present) {
            beginning->mw[receiver] = Milliwatts(dbm);
            beginning->farthestM = std::max(beginning->farthestM, from->GetDistanceFrom(to));
        }
        return dbm;
    }
    int64_t DoAssignStreams(int64_t) override { return 0; }
};

/// Count the time since the last change.
void Account(Station &one, double nowS) {
    if (one.sending || one.airMw >= loadMw) one.busyS += nowS - one.sinceS;
    one.sinceS = nowS;
}

void EndWindow() {
    for (auto &one : stations) {
        Account(one, NowS());
        one.ratio = std::min(1.0, one.busyS / windowS);
        one.busyS = 0.0;
    }
    Simulator::Schedule(Seconds(windowS), &EndWindow);
}

/// Why a frame was lost at a station that was there: the radio's own OUTCOMES.
Outcome Judge(const Frame &frame, uint32_t receiver) {
    double concurrent = 0.0, hidden = 0.0;
    auto meet = [&](const Frame &other) {
        double overlapS = std::min(frame.endS, other.endS) - std::max(frame.startS, other.startS);
        if (&other == &frame || overlapS <= 0.0) return false;
        if (other.sender == receiver) return true;
        bool together = std::abs(frame.startS - other.startS) < slotS;
        (together ? concurrent : hidden) += overlapS * other.mw[receiver];
        return false;
    };
    for (auto &[id, other] : frames)
        if (meet(*other)) return HALF_DUPLEX;
    for (auto &other : judged)
        if (meet(*other)) return HALF_DUPLEX;
    double weak = noiseMw * (frame.endS - frame.startS);
    if (frame.mw[receiver] < sensitivityMw || concurrent + hidden < weak) return BELOW_SENSITIVITY;
    return concurrent >= hidden ? CONCURRENT : HIDDEN;
}

/// All who may receive the frame have: say what became of it.
void Finish(std::shared_ptr<Frame> frame) {
    auto from = stations[frame->sender].mobility->GetPosition();
    for (uint32_t k = 0; k < stations.size(); ++k) {
        if (frame->mw[k] <= 0.0) continue;
        bool got = !std::isnan(frame->receivedS[k]);
        auto to = stations[k].mobility->GetPosition();
        if (!got && std::hypot(to.x - from.x, to.y - from.y) > reachM) continue;
        double atS = got ? frame->receivedS[k] : frame->endS;
        int32_t outcome = got ? RECEIVED : Judge(*frame, k);
        pairs.push_back({frame->id, atS, 10.0 * std::log10(frame->mw[k]), int32_t(k), outcome});
    }
    ended.push_back(frame->id);
    idOfPacket.erase(frame->packet);
    frames.erase(frame->id);
    judged.push_back(frame);
    double earliestS = INFINITY;
    for (auto &[id, other] : frames) earliestS = std::min(earliestS, other->startS);
    while (!judged.empty() && (frames.empty() || judged.front()->endS < earliestS)) judged.pop_front();
}

void Begin(uint32_t k, Ptr<const Packet>, double) {
    Station &one = stations[k];
    size_t count = stations.size();
    beginning = std::make_shared<Frame>(Frame{one.waiting->id, one.packet, k, NowS(), INFINITY, 0.0,
                                              std::vector<double>(count), std::vector<double>(count, NAN)});
    frames[beginning->id] = beginning;
    one.waiting.reset();
    Account(one, NowS());
    one.sending = beginning;
    ++onAir;
    // The powers are known when the channel has asked for all of them, at this same instant.
    Simulator::ScheduleNow(+[](std::shared_ptr<Frame> frame) {
        for (uint32_t j = 0; j < stations.size(); ++j) {
            if (frame->mw[j] <= 0.0) continue;
            Account(stations[j], NowS());
            stations[j].airMw += frame->mw[j];
        }
    }, beginning);
}

void HandOver(std::shared_ptr<Message> message);

void End(uint32_t k, Ptr<const Packet>) {
    Station &one = stations[k];
    auto frame = one.sending;
    frame->endS = NowS();
    Account(one, NowS());
    one.sending.reset();
    --onAir;
    for (uint32_t j = 0; j < stations.size(); ++j) {
        if (frame->mw[j] <= 0.0) continue;
        Account(stations[j], NowS());
        stations[j].airMw = onAir ? std::max(0.0, stations[j].airMw - frame->mw[j]) : 0.0;
    }
    Simulator::Schedule(Seconds(frame->farthestM / LIGHT_MPS + 2e-9), &Finish, frame);
    if (one.later) Simulator::ScheduleNow(&HandOver, std::exchange(one.later, nullptr));
}

bool Heard(uint32_t receiver, Ptr<NetDevice>, Ptr<const Packet> packet, uint16_t, const Address &) {
    auto found = frames.find(idOfPacket.at(packet->GetUid()));
    if (found != frames.end()) found->second->receivedS[receiver] = NowS();
    return true;
}

/// Take back what waits at a station.
void Withdraw(Station &one) {
    if (one.waiting) {
        one.access->GetWifiMacQueue()->Flush();
        idOfPacket.erase(one.packet);
        expired.push_back(one.waiting->id);
        one.waiting.reset();
    }
    if (one.later) expired.push_back(std::exchange(one.later, nullptr)->id);
}

/// A message is ready: it takes the place of one that waits.
void HandOver(std::shared_ptr<Message> message) {
    Station &one = stations[message->sender];
    if (!one.present) {
        expired.push_back(message->id);
        return;
    }
    Withdraw(one);
    if (one.sending) {
        one.later = message;
        return;
    }
    one.waiting = message;
    one.phy->SetTxPowerStart(message->powerDbm);
    one.phy->SetTxPowerEnd(message->powerDbm);
    auto packet = Create<Packet>(uint32_t(message->bytes) - OVERHEAD);
    one.packet = packet->GetUid();
    idOfPacket[one.packet] = message->id;
    one.device->Send(packet, Mac48Address::GetBroadcast(), 0x88dc);
}

template <typename T> bool Read(T *into, size_t count) { return std::fread(into, sizeof(T), count, stdin) == count; }
template <typename T> void Write(const T *from, size_t count) { std::fwrite(from, sizeof(T), count, stdout); }

bool Step() {
    double untilS;
    int64_t count;
    if (!Read(&untilS, 1) || !Read(&count, 1)) return false;
    std::vector<Place> places(stations.size());
    std::vector<Message> messages(count);
    if (!Read(places.data(), places.size()) || !Read(messages.data(), messages.size())) return false;
    for (size_t k = 0; k < stations.size(); ++k) {
        Station &one = stations[k];
        one.present = !std::isnan(places[k].x);
        if (!one.present) Withdraw(one);
        one.mobility->SetPosition(one.present ? Vector(places[k].x, places[k].y, 1.5)
                                              : Vector(ABSENT_M * (k + 1.0), ABSENT_M, 1.5));
    }
    for (auto &one : messages) {
        Time wait = std::max(Seconds(one.readyS) - Simulator::Now(), Time(0));
        Simulator::Schedule(wait, &HandOver, std::make_shared<Message>(one));
    }
    Simulator::Stop(Seconds(untilS) - Simulator::Now());
    Simulator::Run();
    int64_t sizes[3] = {int64_t(pairs.size()), int64_t(ended.size()), int64_t(expired.size())};
    Write(sizes, 3);
    Write(pairs.data(), pairs.size());
    Write(ended.data(), ended.size());
    Write(expired.data(), expired.size());
    for (auto &one : stations) Write(&one.ratio, 1);
    std::fflush(stdout);
    pairs.clear();
    ended.clear();
    expired.clear();
    return true;
}

}  // namespace

int main(int argc, char **argv) {
    uint32_t count = 0, seed = 1, window = 15, aifsn = 2;
    double exponent = 2.0, referenceLossDb = 47.86, noiseFigureDb = 7.0, sensitivityDbm = -98.0, preambleDb = 2.0;
    double energyDbm = -62.0, loadDbm = -85.0;
    std::string errors = "ns3::NistErrorRateModel";
    CommandLine cmd;
    cmd.AddValue("stations", "number of stations", count);
    cmd.AddValue("seed", "of all random numbers", seed);
    cmd.AddValue("exponent", "of the path loss", exponent);
    cmd.AddValue("reference", "loss over 1 m, dB", referenceLossDb);
    cmd.AddValue("noise", "noise figure, dB", noiseFigureDb);
    cmd.AddValue("sensitivity", "weakest frame, dBm", sensitivityDbm);
    cmd.AddValue("preamble", "least ratio at which a preamble is found, dB", preambleDb);
    cmd.AddValue("energy", "power of any kind that holds the medium busy, dBm", energyDbm);
    cmd.AddValue("errors", "class of the error model", errors);
    cmd.AddValue("load", "power that the busy ratio counts, dBm", loadDbm);
    cmd.AddValue("aifsn", "slots of the interframe space beyond SIFS", aifsn);
    cmd.AddValue("window", "largest countdown, slots", window);
    cmd.AddValue("busy-window", "of the busy ratio, s", windowS = 0.1);
    cmd.AddValue("reach", "distance within which losses are told, m", reachM = 500.0);
    cmd.Parse(argc, argv);
    RngSeedManager::SetSeed(seed);
    loadMw = Milliwatts(loadDbm);
    sensitivityMw = Milliwatts(sensitivityDbm);
    noiseMw = 1.380649e-23 * 290.0 * 10e6 * 1e3 * Milliwatts(noiseFigureDb);
    slotS = 13e-6;

    NodeContainer nodes;
    nodes.Create(count);
    stations.resize(count);
    auto loss = CreateObject<LogDistancePropagationLossModel>();
    loss->SetAttribute("Exponent", DoubleValue(exponent));
    loss->SetAttribute("ReferenceLoss", DoubleValue(referenceLossDb));
    auto fading = CreateObject<NakagamiPropagationLossModel>();
    fading->SetAttribute("m0", DoubleValue(3.0));
    fading->SetAttribute("m1", DoubleValue(1.5));
    fading->SetAttribute("m2", DoubleValue(1.0));
    fading->SetAttribute("Distance1", DoubleValue(50.0));
    fading->SetAttribute("Distance2", DoubleValue(150.0));
    loss->SetNext(fading);
    fading->SetNext(CreateObject<PowerTap>());
    auto channel = CreateObject<YansWifiChannel>();
    channel->SetPropagationLossModel(loss);
    channel->SetPropagationDelayModel(CreateObject<ConstantSpeedPropagationDelayModel>());

    YansWifiPhyHelper phy;
    phy.SetChannel(channel);
    phy.Set("ChannelSettings", StringValue("{178, 10, BAND_5GHZ, 0}"));
    phy.Set("RxNoiseFigure", DoubleValue(noiseFigureDb));
    phy.Set("RxSensitivity", DoubleValue(sensitivityDbm));
    phy.Set("CcaEdThreshold", DoubleValue(energyDbm));
    phy.SetErrorRateModel(errors);
    phy.SetPreambleDetectionModel("ns3::ThresholdPreambleDetectionModel", "Threshold", DoubleValue(preambleDb),
                                  "MinimumRssi", DoubleValue(sensitivityDbm));
    WifiMacHelper mac;
    mac.SetType("ns3::AdhocWifiMac");
    WifiHelper wifi;
    wifi.SetStandard(WIFI_STANDARD_80211p);
    auto rate = StringValue("OfdmRate6MbpsBW10MHz");
    wifi.SetRemoteStationManager("ns3::ConstantRateWifiManager", "DataMode", rate, "ControlMode", rate,
                                 "NonUnicastMode", rate);
    MobilityHelper mobility;
    mobility.SetMobilityModel("ns3::ConstantPositionMobilityModel");
    mobility.Install(nodes);
    NetDeviceContainer devices = wifi.Install(phy, mac, nodes);
    for (uint32_t k = 0; k < count; ++k) {
        auto device = DynamicCast<WifiNetDevice>(devices.Get(k));
        Station &one = stations[k];
        one.device = device;
        one.phy = device->GetPhy();
        one.access = device->GetMac()->GetTxop();
        one.access->SetMinCw(window);
        one.access->SetAifsn(uint8_t(aifsn));
        one.mobility = nodes.Get(k)->GetObject<MobilityModel>();
        device->SetReceiveCallback(MakeBoundCallback(&Heard, k));
        one.phy->TraceConnectWithoutContext("PhyTxBegin", MakeBoundCallback(&Begin, k));
        one.phy->TraceConnectWithoutContext("PhyTxEnd", MakeBoundCallback(&End, k));
    }
    Simulator::Schedule(Seconds(windowS), &EndWindow);
    while (Step()) {
    }
    Simulator::Destroy();
    return 0;
}
