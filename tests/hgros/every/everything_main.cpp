// A robot with all that commands can ask for, until it is killed, or its parent ends.
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>

#include "hgros/every/everything.hpp"

int main() {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  hgros::Session session(hgros::Config(), hgros::SessionOptions{"robot"});
  const hgros::cli::Everything everything(session, "");
  for (;;) pause();
}
