
mod identities;
