// Packet error of ns-3's table-based error model in white noise: what validation/ns3_error_tables.py reads.
// Output: rate_mbps bytes snr_db packet_error_ratio, one line each.
#include <cmath>
#include <cstdio>
#include <string>

#include "ns3/core-module.h"
#include "ns3/wifi-module.h"

using namespace ns3;

int main(int argc, char **argv) {
    double from_db = -6.0, to_db = 32.0, step_db = 0.25;
    CommandLine cmd;
    cmd.AddValue("from", "least SNR", from_db);
    cmd.AddValue("to", "largest SNR", to_db);
    cmd.AddValue("step", "of SNR", step_db);
    cmd.Parse(argc, argv);
    auto model = CreateObject<TableBasedErrorRateModel>();
    for (std::string rate : {"3", "6", "9", "12", "18", "24", "27"}) {
        WifiMode mode("OfdmRate" + rate + "MbpsBW10MHz");
        WifiTxVector vector;
        vector.SetMode(mode);
        vector.SetChannelWidth(10);
        vector.SetNss(1);
        for (int bytes : {32, 1458})
            for (int k = 0; from_db + k * step_db <= to_db + 1e-9; ++k) {
                double snr_db = from_db + k * step_db;
                double kept = model->GetChunkSuccessRate(mode, vector, std::pow(10.0, 0.1 * snr_db), 8 * bytes);
                std::printf("%s %d %.2f %.9g\n", rate.c_str(), bytes, snr_db, 1.0 - kept);
            }
    }
    return 0;
}
