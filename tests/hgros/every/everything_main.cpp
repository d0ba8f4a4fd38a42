// A robot with all that commands can ask for, until it is killed.
#include <unistd.h>

#include "hgros/every/everything.hpp"

int main() {
  hgros::Session session(hgros::Config(), hgros::SessionOptions{"robot"});
  const hgros::cli::Everything everything(session, "");
  for (;;) pause();
}
