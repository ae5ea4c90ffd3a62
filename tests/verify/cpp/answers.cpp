// Begins so many sessions one after another, asks for everything in each, and looks at every number of the
// answers; prints a line for each: what went wrong, or "well". A session that has failed is asked again.

#include <cstdio>
#include <cstdlib>

#include "modelcast_client.hpp"

namespace {

double looked_at(modelcast::Client& client) {
    modelcast::Step step;
    step.vehicle = {3, 8}, step.position_m = {0.0, 0.0, 20.0, 0.0};
    step.receiver = {8}, step.received_s = {0.0}, step.message = {0};
    const modelcast::Sent sent = client.step(step);
    double sum = sent.t_s + sent.receipt.at(0);
    const auto frames = sent.frames();
    for (std::size_t row = 0; row < sent.message.size(); ++row) {
        sum += static_cast<double>(sent.message[row]) + sent.send_s[row] + sent.power_dbm[row];
        sum += sent.next_s[row] + sent.frame_bytes[row] + sent.priority[row] + sent.kind[row];
        for (const std::uint8_t octet : frames[row]) sum += octet;
        sum += step.speed_mps.empty() ? 0.0 : step.position_m[2 * (sent.vehicle[row] == 8)];
    }
    const modelcast::Beliefs map = client.map(step.vehicle, 0.0);
    for (std::size_t row = 0; row < map.host.size(); ++row) {
        sum += map.vehicle[row] + map.position_m[2 * row + 1] + map.velocity_mps[2 * row + 1];
        sum += map.speed_mps[row] + map.heading_rad[row] + map.acceleration_mps2[row];
        sum += map.yaw_rate_radps[row] + map.covariance_m2[4 * row + 3] + map.information_age_s[row];
        sum += map.received_s[row] + map.length_m[row] + map.width_m[row] + map.kind[row];
    }
    const std::vector<std::string> applications{"fcw", "eebl"};
    const modelcast::Warned warned = client.warnings(step.vehicle, applications);
    for (std::size_t row = 0; row < warned.host.size(); ++row) {
        sum += warned.vehicle[row] + warned.level[row] + warned.time_s[row] + warned.margin_m[row];
        sum += warned.certainty[row] + static_cast<double>(applications[warned.application[row]].size());
    }
    return sum;
}

}  // namespace

int main(int, char** arguments) {
    const long sessions = std::strtol(arguments[2], nullptr, 10);
    const auto silence_s = static_cast<std::uint32_t>(std::strtol(arguments[3], nullptr, 10));
    for (long one = 0; one < sessions; ++one) {
        std::string first;
        try {
            modelcast::Client client =
                modelcast::Client::at_socket(arguments[1], modelcast::Settings(), silence_s);
            try {
                looked_at(client);
                std::printf("well\n");
            } catch (const modelcast::Refused& error) {
                std::printf("refused: %s, ends %d\n", error.field.c_str(), error.ends);
            } catch (const std::exception& error) {
                first = error.what();
                client.map({3}, 0.0);
            }
        } catch (const std::exception& error) {
            if (first.empty()) std::printf("begin: %s\n", error.what());
            else if (error.what() != "the session has ended: " + first) std::printf("%s!\n", error.what());
            else std::printf("%s\n", first.c_str());
        }
    }
    return 0;
}
