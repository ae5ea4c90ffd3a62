// A client of modelcast's step protocol (docs/serve.md) in one header: C++17, POSIX sockets, nothing else.
//
//     modelcast::Client client = modelcast::Client::at_socket("/run/modelcast.sock", settings);
//     modelcast::Sent sent = client.step(step);
//
// Times are in seconds, lengths in metres, angles in radians clockwise from north. The comment behind a field
// is its type on the wire. A request that the server refuses throws modelcast::Refused; where its `ends` is
// false the session goes on as if it had not been asked.

#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace modelcast {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "arrays travel as little-endian numbers");
static_assert(std::numeric_limits<double>::is_iec559 && sizeof(double) == 8, "doubles are those of IEEE 754");

constexpr int kProtocol = 1;
constexpr std::uint32_t kFrameBytes = 33554432;
constexpr std::int64_t kForeign = -1;  // number of a message that the session did not send

enum class Kind : std::uint8_t { vehicle = 0, pedestrian = 1, cyclist = 2, road_worker = 3, roadside = 4 };

using Octets = std::vector<std::uint8_t>;

// The server refused a request: which field, what came, and what was expected.
struct Refused : std::runtime_error {
    explicit Refused(const std::string& text) : std::runtime_error(text) {}
    std::string field, value, expected;
    bool ends = false;
};

// What a session is begun with.
struct Settings {
    std::int64_t slots = 1, people_slots = 0, seed = 0, capacity = 500;             // integer
    double dt_s = 0.1, latitude_deg = 0.0, longitude_deg = 0.0, altitude_m = 0.0;   // number
    double minute_s = 0.0, spread_s = 0.0, threshold_m = 0.2, keep_alive_s = 1.0;   // number
    std::string sender = "mbc";                                                     // text

    template <class F>
    void each(F&& f) const {
        f("slots", slots), f("sender", sender), f("people_slots", people_slots), f("dt_s", dt_s);
        f("latitude_deg", latitude_deg), f("longitude_deg", longitude_deg), f("altitude_m", altitude_m);
        f("seed", seed), f("minute_s", minute_s), f("spread_s", spread_s), f("capacity", capacity);
        f("threshold_m", threshold_m), f("keep_alive_s", keep_alive_s);
    }
};

// All stations at one time, and what was received since the last step. An optional array that is empty is
// left out; of one with rows of several numbers the rows stand one after another.
struct Step {
    double t_s = 0.0;                                                               // number
    std::vector<std::uint32_t> vehicle;                                             // u4[N]
    std::vector<double> position_m;                                                 // f8[N,2]
    std::vector<double> speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps;  // f8[N]
    std::vector<double> busy_ratio;                                                 // f8[N]
    std::vector<std::uint8_t> kind, begins;                                         // u1[N]
    std::vector<std::uint32_t> receiver;                                            // u4[K]
    std::vector<double> received_s;                                                 // f8[K]
    std::vector<std::int64_t> message;                                              // i8[K]
    std::vector<std::uint32_t> foreign_length;                                      // u4[F]
    Octets foreign_octets;                                                          // octets

    template <class F>
    void each(F&& f) const {
        f("t_s", t_s), f("vehicle", vehicle), f("position_m", position_m);
        const auto given = [&f](const char* name, const auto& values) {
            if (!values.empty()) f(name, values);
        };
        given("speed_mps", speed_mps), given("heading_rad", heading_rad);
        given("acceleration_mps2", acceleration_mps2), given("yaw_rate_radps", yaw_rate_radps);
        given("busy_ratio", busy_ratio), given("kind", kind), given("begins", begins);
        given("receiver", receiver), given("received_s", received_s), given("message", message);
        given("foreign_length", foreign_length), given("foreign_octets", foreign_octets);
    }
};

// What stations send until the next step, in order of time, and what became of the receptions.
struct Sent {
    double t_s = 0.0;                                                               // number
    std::vector<std::int64_t> message;                                              // i8[M]
    std::vector<std::uint32_t> vehicle, frame_bytes, length;                        // u4[M]
    std::vector<double> send_s, power_dbm, next_s;                                  // f8[M]
    std::vector<std::uint8_t> priority, kind;                                       // u1[M]
    Octets octets;                                                                  // octets
    std::vector<std::uint8_t> receipt;                                              // u1[K]
    std::vector<std::uint32_t> left;                                                // u4[L]

    template <class F>
    void each(F&& f) {
        f("t_s", t_s), f("message", message), f("vehicle", vehicle), f("send_s", send_s);
        f("frame_bytes", frame_bytes), f("power_dbm", power_dbm), f("priority", priority);
        f("next_s", next_s), f("kind", kind), f("length", length), f("octets", octets);
        f("receipt", receipt), f("left", left);
    }

    // Octets of each message.
    std::vector<Octets> frames() const {
        std::vector<Octets> found;
        auto at = octets.begin();
        for (const std::uint32_t own : length) {
            if (own > octets.end() - at) throw std::runtime_error("lengths of messages exceed their octets");
            found.emplace_back(at, at + own);
            at += own;
        }
        return found;
    }
};

// Local dynamic maps, host after host as asked, remotes by rising id.
struct Beliefs {
    double t_s = 0.0;                                                               // number
    std::vector<std::uint32_t> host, vehicle;                                       // u4[B]
    std::vector<double> position_m, velocity_mps;                                   // f8[B,2]
    std::vector<double> speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps;  // f8[B]
    std::vector<double> covariance_m2;                                              // f8[B,2,2]
    std::vector<double> information_age_s, received_s, length_m, width_m;           // f8[B]
    std::vector<std::uint8_t> kind;                                                 // u1[B]

    template <class F>
    void each(F&& f) {
        f("t_s", t_s), f("host", host), f("vehicle", vehicle), f("position_m", position_m);
        f("velocity_mps", velocity_mps), f("speed_mps", speed_mps), f("heading_rad", heading_rad);
        f("acceleration_mps2", acceleration_mps2), f("yaw_rate_radps", yaw_rate_radps);
        f("covariance_m2", covariance_m2), f("information_age_s", information_age_s);
        f("received_s", received_s), f("kind", kind), f("length_m", length_m), f("width_m", width_m);
    }
};

// What safety applications say: pairs of host and remote with a level above none.
struct Warned {
    double t_s = 0.0;                                                               // number
    std::vector<std::uint32_t> host, vehicle;                                       // u4[W]
    std::vector<std::uint8_t> application, level;                                   // u1[W]
    std::vector<double> time_s, margin_m, certainty;                                // f8[W]

    template <class F>
    void each(F&& f) {
        f("t_s", t_s), f("host", host), f("vehicle", vehicle), f("application", application);
        f("level", level), f("time_s", time_s), f("margin_m", margin_m), f("certainty", certainty);
    }
};

// Writes one map of MessagePack: a type and fields.
class Writer {
public:
    explicit Writer(const char* type) { (*this)("type", std::string(type)); }

    template <class T>
    void operator()(const char* name, const T& value) {
        put(std::string(name));
        put(value);
        ++fields_;
    }
    // The frame: length, map of so many fields, fields.
    Octets frame() const {
        const auto octet = [](std::size_t value, int by) { return static_cast<std::uint8_t>(value >> by); };
        const std::size_t length = fields_octets_.size() + 3;
        Octets found{octet(length, 0), octet(length, 8), octet(length, 16), octet(length, 24),
                     0xde, octet(fields_, 8), octet(fields_, 0)};
        found.insert(found.end(), fields_octets_.begin(), fields_octets_.end());
        return found;
    }

private:
    void big(std::uint8_t head, std::uint64_t value, int octets) {
        fields_octets_.push_back(head);
        while (octets--) fields_octets_.push_back(static_cast<std::uint8_t>(value >> (8 * octets)));
    }
    void put(std::int64_t value) { big(0xd3, static_cast<std::uint64_t>(value), 8); }
    void put(double value) {
        std::uint64_t bits;
        std::memcpy(&bits, &value, sizeof bits);
        big(0xcb, bits, 8);
    }
    void put(const std::string& value) {
        big(0xdb, value.size(), 4);
        fields_octets_.insert(fields_octets_.end(), value.begin(), value.end());
    }
    void put(const std::vector<std::string>& values) {
        big(0xdd, values.size(), 4);
        for (const std::string& one : values) put(one);
    }
    template <class T>
    void put(const std::vector<T>& values) {
        static_assert(std::is_arithmetic_v<T>);
        const auto* first = reinterpret_cast<const std::uint8_t*>(values.data());
        big(0xc6, values.size() * sizeof(T), 4);
        fields_octets_.insert(fields_octets_.end(), first, first + values.size() * sizeof(T));
    }
    Octets fields_octets_;
    unsigned fields_ = 0;
};

// Reads one map of MessagePack whose values are numbers, texts, flags and binaries.
class Reader {
public:
    explicit Reader(const Octets& octets) : at_(octets.data()), end_(octets.data() + octets.size()) {
        const std::uint8_t head = byte();
        std::uint64_t fields = head & 0x0f;
        if (head == 0xde) fields = big(2);
        else if ((head & 0xf0) != 0x80) throw std::runtime_error("the answer is no map of MessagePack");
        while (fields--) {
            const std::string name = value().octets;
            values_[name] = value();
        }
    }
    void operator()(const char* name, double& out) const { out = find(name).number; }
    void operator()(const char* name, bool& out) const { out = find(name).number != 0.0; }
    void operator()(const char* name, std::string& out) const { out = find(name).octets; }
    template <class T>
    void operator()(const char* name, std::vector<T>& out) const {
        const std::string& octets = find(name).octets;
        if (octets.size() % sizeof(T)) throw std::runtime_error(std::string("a part of a number in ") + name);
        out.resize(octets.size() / sizeof(T));
        if (!octets.empty()) std::memcpy(out.data(), octets.data(), octets.size());
    }

private:
    struct Value {
        double number = 0.0;
        std::string octets;
    };
    const Value& find(const char* name) const {
        const auto found = values_.find(name);
        if (found == values_.end()) throw std::runtime_error(std::string("the answer has no ") + name);
        return found->second;
    }
    void need(std::uint64_t octets) const {
        const auto left = static_cast<std::uint64_t>(end_ - at_);
        if (left < octets) throw std::runtime_error("the answer is cut off");
    }
    std::uint8_t byte() { return static_cast<std::uint8_t>(big(1)); }
    std::uint64_t big(int octets) {
        need(static_cast<std::uint64_t>(octets));
        std::uint64_t found = 0;
        while (octets--) found = found << 8 | *at_++;
        return found;
    }
    Value bytes(std::uint64_t count) {
        need(count);
        Value found;
        found.octets.assign(reinterpret_cast<const char*>(at_), count);
        at_ += count;
        return found;
    }
    static Value number(double value) { return {value, {}}; }
    Value value() {
        const std::uint8_t head = byte();
        if (head < 0x80) return number(head);
        if (head >= 0xe0) return number(static_cast<std::int8_t>(head));
        if ((head & 0xe0) == 0xa0) return bytes(head & 0x1f);
        switch (head) {
            case 0xc0: case 0xc2: return number(0.0);
            case 0xc3: return number(1.0);
            case 0xc4: case 0xd9: return bytes(big(1));
            case 0xc5: case 0xda: return bytes(big(2));
            case 0xc6: case 0xdb: return bytes(big(4));
            case 0xcb: {
                const std::uint64_t bits = big(8);
                double found;
                std::memcpy(&found, &bits, sizeof found);
                return number(found);
            }
            case 0xcc: case 0xcd: case 0xce: case 0xcf:
                return number(static_cast<double>(big(1 << (head - 0xcc))));
            case 0xd0: return number(static_cast<std::int8_t>(big(1)));
            case 0xd1: return number(static_cast<std::int16_t>(big(2)));
            case 0xd2: return number(static_cast<std::int32_t>(big(4)));
            case 0xd3: return number(static_cast<double>(static_cast<std::int64_t>(big(8))));
            default: throw std::runtime_error("the answer holds what this protocol has not");
        }
    }
    const std::uint8_t* at_;
    const std::uint8_t* end_;
    std::map<std::string, Value> values_;
};

// A session; ends with its object.
class Client {
public:
    static Client at_socket(const std::string& path, const Settings& settings) {
        sockaddr_un place{};
        place.sun_family = AF_UNIX;
        if (path.size() >= sizeof place.sun_path) throw std::runtime_error("too long a path: " + path);
        std::memcpy(place.sun_path, path.c_str(), path.size());
        return Client(AF_UNIX, reinterpret_cast<const sockaddr*>(&place), sizeof place, path, settings);
    }
    static Client at_port(std::uint16_t port, const Settings& settings) {
        sockaddr_in place{};
        place.sin_family = AF_INET;
        place.sin_port = htons(port);
        place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        return Client(AF_INET, reinterpret_cast<const sockaddr*>(&place), sizeof place,
                      "port " + std::to_string(port), settings);
    }
    Client(const Client&) = delete;
    Client& operator=(Client) = delete;
    Client(Client&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}
    ~Client() {
        if (socket_ >= 0) ::close(socket_);
    }

    Sent step(const Step& step) { return ask<Sent>("step", "sent", [&](Writer& to) { step.each(to); }); }
    Beliefs map(const std::vector<std::uint32_t>& host, double t_s) {
        return ask<Beliefs>("map", "beliefs", [&](Writer& to) { to("t_s", t_s), to("host", host); });
    }
    Warned warnings(const std::vector<std::uint32_t>& host, const std::vector<std::string>& applications) {
        return ask<Warned>("warnings", "warned",
                           [&](Writer& to) { to("host", host), to("applications", applications); });
    }

private:
    struct Welcome {
        std::string version, sender;
        template <class F>
        void each(F&& f) { f("version", version), f("sender", sender); }
    };
    Client(int family, const sockaddr* place, socklen_t size, const std::string& name, const Settings& given)
        : socket_(::socket(family, SOCK_STREAM, 0)) {
        const int on = 1;
        if (family == AF_INET) ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        if (socket_ < 0 || ::connect(socket_, place, size) != 0) fail("cannot reach the server at " + name);
        try {
            ask<Welcome>("hello", "welcome", [&](Writer& to) {
                to("protocol", std::int64_t{kProtocol});
                given.each(to);
            });
        } catch (...) {
            ::close(socket_);
            throw;
        }
    }
    [[noreturn]] void fail(const std::string& what) {
        const std::string why = std::strerror(errno);
        if (socket_ >= 0) ::close(std::exchange(socket_, -1));
        throw std::runtime_error(what + ": " + why);
    }
    template <class Answer, class Fill>
    Answer ask(const char* type, const char* wanted, Fill&& fill) {
        Writer to(type);
        fill(to);
        const Octets frame = to.frame();
        for (std::size_t at = 0; at < frame.size();) {
            const ssize_t went = ::send(socket_, frame.data() + at, frame.size() - at, MSG_NOSIGNAL);
            if (went < 0 && errno != EINTR) throw std::runtime_error("the server ended the session");
            if (went > 0) at += static_cast<std::size_t>(went);
        }
        const Octets head = read(4);
        const std::uint32_t length = head[0] | head[1] << 8 | head[2] << 16 | std::uint32_t{head[3]} << 24;
        if (length > kFrameBytes) throw std::runtime_error("too long an answer");
        const Reader from(read(length));
        std::string kind;
        from("type", kind);
        if (kind == "error") {
            std::string text;
            from("text", text);
            Refused refused(text);
            from("field", refused.field), from("value", refused.value);
            from("expected", refused.expected), from("ends", refused.ends);
            throw refused;
        }
        if (kind != wanted) throw std::runtime_error("an answer of another type: " + kind);
        Answer answer;
        answer.each(from);
        return answer;
    }
    Octets read(std::size_t count) {
        Octets found(count);
        for (std::size_t at = 0; at < count;) {
            const ssize_t came = ::recv(socket_, found.data() + at, count - at, 0);
            if (came == 0 || (came < 0 && errno != EINTR))
                throw std::runtime_error("the server ended the session");
            if (came > 0) at += static_cast<std::size_t>(came);
        }
        return found;
    }
    int socket_;
};

}  // namespace modelcast
