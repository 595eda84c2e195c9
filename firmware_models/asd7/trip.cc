#include "firmware_models/asd7/trip.h"

#include <algorithm>
#include <array>

namespace virtdrive::asd7 {
namespace {

struct Name {
  Trip trip;
  std::string_view text;
};
constexpr std::array kNames = {
    Name{Trip::kOc1, "OC1"},   Name{Trip::kOc2, "OC2"},   Name{Trip::kOc3, "OC3"},
    Name{Trip::kOcl, "OCL"},   Name{Trip::kOca, "OCA"},   Name{Trip::kEphi, "EPHI"},
    Name{Trip::kEpho, "EPHO"}, Name{Trip::kOp1, "OP1"},   Name{Trip::kOp2, "OP2"},
    Name{Trip::kOp3, "OP3"},   Name{Trip::kOl1, "OL1"},   Name{Trip::kOl2, "OL2"},
    Name{Trip::kOlr, "OLr"},   Name{Trip::kOh, "OH"},     Name{Trip::kE, "E"},
    Name{Trip::kEep1, "EEP1"}, Name{Trip::kEep2, "EEP2"}, Name{Trip::kEep3, "EEP3"},
    Name{Trip::kErr2, "Err2"}, Name{Trip::kErr3, "Err3"}, Name{Trip::kErr4, "Err4"},
    Name{Trip::kErr5, "Err5"}, Name{Trip::kErr7, "Err7"}, Name{Trip::kUc, "UC"},
    Name{Trip::kUp1, "UP1"},   Name{Trip::kOt, "Ot"},     Name{Trip::kEf2, "EF2"},
    Name{Trip::kOh2, "OH2"}};

}  // namespace

std::string_view trip_name(Trip trip) {
  const auto found = std::ranges::find(kNames, trip, &Name::trip);
  return found != kNames.end() ? found->text : "";
}

}  // namespace virtdrive::asd7
