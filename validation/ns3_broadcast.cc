// Broadcast of a fixed set of IEEE 802.11p nodes, counted by pair: the reference run of validation/ns3.py and
// validation/ns3_load.py.
// Input file: one line a node, "x y phase_s". Output: sender receiver received, one line a pair that received.
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "ns3/core-module.h"
#include "ns3/mobility-module.h"
#include "ns3/network-module.h"
#include "ns3/propagation-module.h"
#include "ns3/wifi-module.h"

using namespace ns3;

static std::vector<std::vector<uint32_t>> received;

static bool Heard(uint32_t receiver, Ptr<NetDevice>, Ptr<const Packet>, uint16_t, const Address &from) {
    uint8_t bytes[6];
    Mac48Address::ConvertFrom(from).CopyTo(bytes);
    uint32_t sender = bytes[4] * 256u + bytes[5] - 1u;
    received[sender][receiver]++;
    return true;
}

static void Send(Ptr<NetDevice> device, uint32_t bytes, double period, double until) {
    device->Send(Create<Packet>(bytes), Mac48Address::GetBroadcast(), 0x88dc);
    if (Simulator::Now().GetSeconds() + period < until)
        Simulator::Schedule(Seconds(period), &Send, device, bytes, period, until);
}

int main(int argc, char **argv) {
    std::string path;
    std::string mode = "OfdmRate6MbpsBW10MHz", errors = "ns3::NistErrorRateModel";
    double seconds = 10.0, period = 0.1, exponent = 2.4, tail = 0.0;
    uint32_t bytes = 300, seed = 1;
    CommandLine cmd;
    cmd.AddValue("nodes", "file of nodes", path);
    cmd.AddValue("seconds", "how long messages are sent", seconds);
    cmd.AddValue("tail", "how long to go on after that", tail);
    cmd.AddValue("mode", "bit rate", mode);
    cmd.AddValue("errors", "error model", errors);
    cmd.AddValue("exponent", "of path loss", exponent);
    cmd.AddValue("bytes", "payload", bytes);
    cmd.AddValue("seed", "seed", seed);
    cmd.Parse(argc, argv);
    RngSeedManager::SetSeed(seed);

    std::vector<double> phases;
    auto places = CreateObject<ListPositionAllocator>();
    std::ifstream file(path);
    double x, y, phase;
    while (file >> x >> y >> phase) {
        places->Add(Vector(x, y, 1.5));
        phases.push_back(phase);
    }
    NodeContainer nodes;
    nodes.Create(phases.size());
    received.assign(phases.size(), std::vector<uint32_t>(phases.size(), 0));

    YansWifiChannelHelper channel;
    channel.SetPropagationDelay("ns3::ConstantSpeedPropagationDelayModel");
    channel.AddPropagationLoss("ns3::LogDistancePropagationLossModel", "Exponent", DoubleValue(exponent),
                               "ReferenceLoss", DoubleValue(47.86));
    channel.AddPropagationLoss("ns3::NakagamiPropagationLossModel", "m0", DoubleValue(3.0), "m1", DoubleValue(1.5),
                               "m2", DoubleValue(1.0), "Distance1", DoubleValue(50.0), "Distance2",
                               DoubleValue(150.0));
    YansWifiPhyHelper phy;
    phy.SetChannel(channel.Create());
    phy.Set("ChannelSettings", StringValue("{178, 10, BAND_5GHZ, 0}"));
    phy.Set("TxPowerStart", DoubleValue(20.0));
    phy.Set("TxPowerEnd", DoubleValue(20.0));
    phy.Set("RxSensitivity", DoubleValue(-98.0));
    phy.SetErrorRateModel(errors);
    phy.SetPreambleDetectionModel("ns3::ThresholdPreambleDetectionModel", "Threshold", DoubleValue(2.0),
                                  "MinimumRssi", DoubleValue(-98.0));
    WifiMacHelper mac;
    mac.SetType("ns3::AdhocWifiMac");
    WifiHelper wifi;
    wifi.SetStandard(WIFI_STANDARD_80211p);
    wifi.SetRemoteStationManager("ns3::ConstantRateWifiManager", "DataMode", StringValue(mode), "ControlMode",
                                 StringValue(mode), "NonUnicastMode", StringValue(mode));
    NetDeviceContainer devices = wifi.Install(phy, mac, nodes);
    MobilityHelper mobility;
    mobility.SetPositionAllocator(places);
    mobility.SetMobilityModel("ns3::ConstantPositionMobilityModel");
    mobility.Install(nodes);
    for (uint32_t k = 0; k < nodes.GetN(); ++k) {
        uint8_t mine[6] = {0, 0, 0, 0, uint8_t((k + 1) / 256), uint8_t((k + 1) % 256)};
        Mac48Address address;
        address.CopyFrom(mine);
        devices.Get(k)->SetAddress(address);
        devices.Get(k)->SetReceiveCallback(MakeBoundCallback(&Heard, k));
        Simulator::Schedule(Seconds(phases[k]), &Send, devices.Get(k), bytes, period, seconds);
    }
    Simulator::Stop(Seconds(seconds + tail));
    Simulator::Run();
    for (uint32_t i = 0; i < nodes.GetN(); ++i)
        for (uint32_t j = 0; j < nodes.GetN(); ++j)
            if (received[i][j] > 0) std::cout << i << ' ' << j << ' ' << received[i][j] << '\n';
    Simulator::Destroy();
    return 0;
}
