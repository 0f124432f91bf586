mod identities;
mod oracles;
mod robot;
