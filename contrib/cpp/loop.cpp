// Vehicles on a line, a radio that carries 150 m, and modelcast for everything between.
//
//     modelcast serve --socket modelcast.sock &
//     g++ -std=c++17 -O2 loop.cpp -o loop && ./loop modelcast.sock 5 10
//
// Arguments: the server's socket, how many vehicles, how many seconds. Prints what each vehicle heard, and at
// the end its map.

#include "modelcast_client.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>

namespace {

constexpr double kStep_s = 0.1, kReach_m = 150.0, kGap_m = 60.0, kDelay_s = 0.001;

// Everybody goes north; each brakes and speeds up in turn.
void drive(modelcast::Step& step, double t_s) {
    step.t_s = t_s;
    for (std::size_t one = 0; one < step.vehicle.size(); ++one) {
        const double phase = 0.4 * t_s + static_cast<double>(one);
        step.acceleration_mps2[one] = 0.8 * std::cos(phase);
        step.speed_mps[one] = 15.0 + 2.0 * std::sin(phase);
        if (t_s > 0.0) step.position_m[2 * one + 1] += kStep_s * step.speed_mps[one];
    }
}

// Who is near enough hears, a millisecond after it was sent.
void carry(const modelcast::Sent& sent, modelcast::Step& step, std::vector<unsigned>& heard) {
    step.receiver.clear(), step.received_s.clear(), step.message.clear();
    for (std::size_t row = 0; row < sent.message.size(); ++row) {
        const std::size_t sender = sent.vehicle[row] - step.vehicle.front();
        for (std::size_t host = 0; host < step.vehicle.size(); ++host) {
            const double away_m = std::abs(step.position_m[2 * host + 1] - step.position_m[2 * sender + 1]);
            if (host == sender || away_m > kReach_m) continue;
            step.receiver.push_back(step.vehicle[host]);
            step.received_s.push_back(std::min(sent.send_s[row] + kDelay_s, sent.t_s + kStep_s));
            step.message.push_back(sent.message[row]);
            ++heard[host];
        }
    }
}

int run(const char* path, std::size_t vehicles, double duration_s) {
    modelcast::Settings settings;
    settings.slots = static_cast<std::int64_t>(vehicles);
    settings.dt_s = kStep_s;
    modelcast::Client client = modelcast::Client::at_socket(path, settings);

    modelcast::Step step;
    for (std::size_t one = 0; one < vehicles; ++one) {
        step.vehicle.push_back(static_cast<std::uint32_t>(one + 1));
        step.position_m.insert(step.position_m.end(), {0.0, -kGap_m * static_cast<double>(one)});
    }
    step.speed_mps.assign(vehicles, 0.0), step.heading_rad.assign(vehicles, 0.0);
    step.acceleration_mps2.assign(vehicles, 0.0), step.yaw_rate_radps.assign(vehicles, 0.0);
    std::vector<unsigned> sent_count(vehicles), heard(vehicles);
    const int steps = static_cast<int>(std::lround(duration_s / kStep_s));
    for (int number = 0; number < steps; ++number) {
        drive(step, kStep_s * number);
        const modelcast::Sent sent = client.step(step);
        for (const std::uint32_t who : sent.vehicle) ++sent_count[who - 1];
        carry(sent, step, heard);
    }
    for (std::size_t one = 0; one < vehicles; ++one)
        std::printf("vehicle %u sent %u, heard %u\n", step.vehicle[one], sent_count[one], heard[one]);
    // What was sent in the last step has not been told to anybody: the map is that of the last step's time.
    const modelcast::Beliefs map = client.map(step.vehicle, step.t_s);
    for (std::size_t row = 0; row < map.host.size(); ++row) {
        // The client has looked at senders and hosts; a remote may be anybody who was heard.
        const std::uint32_t remote = map.vehicle[row];
        if (remote < 1 || remote > vehicles) throw modelcast::BadAnswer("vehicle", "is none of the loop's");
        const double off_m = map.position_m[2 * row + 1] - step.position_m[2 * (remote - 1) + 1];
        std::printf("vehicle %u believes %u at north %.1f m, %.2f m off, %.1f m/s\n", map.host[row],
                    remote, map.position_m[2 * row + 1], off_m, map.speed_mps[row]);
    }
    return 0;
}

}  // namespace

int main(int count, char** arguments) {
    const long vehicles = count == 4 ? std::strtol(arguments[2], nullptr, 10) : 0;
    const double duration_s = count == 4 ? std::strtod(arguments[3], nullptr) : 0.0;
    if (vehicles < 1 || !(duration_s > 0.0)) {
        std::fprintf(stderr, "usage: %s SOCKET VEHICLES SECONDS\n", arguments[0]);
        return 2;
    }
    try {
        return run(arguments[1], static_cast<std::size_t>(vehicles), duration_s);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
