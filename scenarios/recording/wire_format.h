// The numbers of a wire recording: pcapng (IETF draft-ietf-opsawg-pcapng) with blocks and options
// of our own for what no packet holds. docs/recordings.md describes the whole.
//
// The codes of our own are from the ranges for local use (draft, 3.5 and 10.1): readers skip them.
// Custom blocks would need an enterprise number, and Wireshark shows them between the packets.
#pragma once

#include <cstddef>
#include <cstdint>

namespace virtdrive::wire_format {

// Blocks
inline constexpr std::uint32_t kSection = 0x0A0D0D0A;
inline constexpr std::uint32_t kInterface = 1;
inline constexpr std::uint32_t kPacket = 6;
inline constexpr std::uint32_t kFile = 0x80766401;
inline constexpr std::uint32_t kHostSettings = 0x80766402;
inline constexpr std::uint32_t kHostWrite = 0x80766403;
inline constexpr std::uint32_t kEnd = 0x80766404;

inline constexpr std::uint32_t kByteOrderMagic = 0x1A2B3C4D;
inline constexpr std::uint16_t kLinkType = 147;  // LINKTYPE_USER0
inline constexpr int kVersion = 1;               // of the bench's description

// Options
inline constexpr std::uint16_t kEndOfOptions = 0;
inline constexpr std::uint16_t kComment = 1;
inline constexpr std::uint16_t kInterfaceName = 2;
inline constexpr std::uint16_t kInterfaceDescription = 3;
inline constexpr std::uint16_t kInterfaceSpeed = 8;
inline constexpr std::uint16_t kTimeResolution = 9;
inline constexpr std::uint16_t kApplication = 4;  // of the section
inline constexpr std::uint16_t kPacketFlags = 2;
inline constexpr std::uint16_t kByteTimes = 0x8001;

// Packet flags
inline constexpr std::uint32_t kInbound = 1;
inline constexpr std::uint32_t kOutbound = 2;
inline constexpr std::uint32_t kDirections = 3;
inline constexpr std::uint32_t kCrcError = 1U << 24;
inline constexpr std::uint32_t kTooShort = 1U << 26;
inline constexpr std::uint32_t kUnaligned = 1U << 28;
inline constexpr std::uint32_t kStartError = 1U << 29;
inline constexpr std::uint32_t kSymbolError = 1U << 31;

// Host blocks' flags
inline constexpr std::uint32_t kBeforeEvents = 1;

// Maxima: of what is written, and so of what is believed.
inline constexpr std::size_t kLongestBlock = 16U << 20;
inline constexpr std::size_t kLongestPacket = 1U << 16;
inline constexpr std::size_t kMostLines = 64;
inline constexpr std::int64_t kLatestNs = 400LL * 24 * 3600 * 1'000'000'000;

}  // namespace virtdrive::wire_format
